// Timing of one thing, warm and alone.
#pragma once

#include "render/stopwatch.h"
#include "validate/record.h"

#include <algorithm>
#include <numeric>

namespace opaline {

struct TimingPlan {
  int runs = 3;                 ///< at least
  double max_seconds = 5;       ///< no further run is begun beyond this
  double enough_seconds = 0.1;  ///< short work is repeated until its runs add up to this, or to `most` runs
  int most = 30;
};

/// Runs `work` once to fill caches, which doesn't count, then as planned. Work that takes longer than max_seconds is
/// run once, and that run counts. `spent` gains the seconds of all runs.
template <typename Work>
Timing warm_times(const TimingPlan& plan, double& spent, const Work& work) {
  Stopwatch watch;
  work();
  const double first = watch.lap();
  spent += first;
  if (first > plan.max_seconds) return make_timing({first});
  std::vector<double> values;
  const auto sum = [&] { return std::accumulate(values.begin(), values.end(), 0.0); };
  const auto count = [&] { return static_cast<int>(values.size()); };
  do {
    watch.lap();
    work();
    values.push_back(watch.lap());
  } while (first + sum() < plan.max_seconds &&
           (count() < plan.runs || (sum() < plan.enough_seconds && count() < plan.most)));
  spent += sum();
  return make_timing(std::move(values));
}

}  // namespace opaline
