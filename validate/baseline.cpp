#include "validate/baseline.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Relative standard error of the median: 1.25 s / sqrt(n) for scatter s; unknown (large) for one run.
double relative_noise(const Timing& t) {
  if (t.values.size() < 2 || !(t.median > 0)) return 0.25;
  double squares = 0;
  for (const double v : t.values) squares += (v / t.median - 1) * (v / t.median - 1);
  const double n = static_cast<double>(t.values.size());
  return 1.25 * std::sqrt(squares / (n - 1) / n);
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Pair {
  const Record *before, *now;
};

const Timing& timing(const Record& r, bool render) { return render ? r.seconds.render : r.seconds.prepare; }

double machine_factor(const std::vector<Pair>& pairs) {
  std::vector<double> ratios;
  for (const Pair& p : pairs)
    if (p.before->seconds.render.median > 0)
      ratios.push_back(p.now->seconds.render.median / p.before->seconds.render.median);
  return median_of(std::move(ratios));
}

void compare_times(const Pair& p, bool render, double factor, std::vector<Change>& changes) {
  const Timing &a = timing(*p.before, render), &b = timing(*p.now, render);
  // Below a tenth of a millisecond the clock and the scheduler are what is measured.
  if (std::min(a.median, b.median) < 1e-4) return;
  const double noise = std::hypot(relative_noise(a), relative_noise(b));
  const double tolerance = std::max(0.25, 4 * noise);
  const double by_median = b.median / a.median / factor, by_min = b.min / a.min / factor;
  const bool slower = std::min(by_median, by_min) > 1 + tolerance,
             faster = std::max(by_median, by_min) < 1 / (1 + tolerance);
  if (slower || faster)
    changes.push_back(
        {p.now->name(), render ? "render seconds" : "prepare seconds", a.median, b.median, tolerance, slower});
}

void compare_errors(const Pair& p, std::vector<Change>& changes) {
  for (const char* metric : {"relative_rmse", "flip", "p99"}) {
    const auto a = p.before->error.find(metric), b = p.now->error.find(metric);
    if (a == p.before->error.end() || b == p.now->error.end() || a->second == b->second) continue;
    const double scale = std::max(std::abs(a->second), 1e-7);
    if (std::abs(b->second - a->second) > 0.01 * scale)
      changes.push_back(
          {p.now->name(), std::string("error ") + metric, a->second, b->second, 0.01, b->second > a->second});
  }
}

using Counts = std::map<std::string, std::uint64_t>;

/// Of every name that one of the two has. Work that was never counted and none at all are not the same: one that
/// appears or vanishes is said even with a count of 0.
void compare_counts(const std::string& cell, const std::string& kind, const Counts& before, const Counts& now,
                    std::vector<Change>& changes) {
  Counts names = before;
  names.insert(now.begin(), now.end());
  for (const auto& [name, any] : names) {
    const auto a = before.find(name), b = now.find(name);
    const bool appears = a == before.end(), vanishes = b == now.end();
    if (!appears && !vanishes && a->second == b->second) continue;
    changes.push_back({cell,
                       "counter " + kind + name +
                           (appears    ? " (new)"
                            : vanishes ? " (gone)"
                                       : ""),
                       appears ? 0 : static_cast<double>(a->second), vanishes ? 0 : static_cast<double>(b->second), 0,
                       false});
  }
}

void compare_counters(const Pair& p, std::vector<Change>& changes) {
  compare_counts(p.now->name(), "done.", p.before->done, p.now->done, changes);
  compare_counts(p.now->name(), "skipped.", p.before->skipped, p.now->skipped, changes);
}

}  // namespace

bool BaselineComparison::any_worse() const {
  return std::any_of(changes.begin(), changes.end(), [](const Change& c) { return c.worse; });
}

BaselineComparison compare_with_baseline(const std::vector<Record>& before, const std::vector<Record>& now) {
  BaselineComparison result;
  std::map<std::string, const Record*> by_name;
  for (const Record& r : before) by_name[r.name()] = &r;
  std::vector<Pair> pairs;
  for (const Record& r : now) {
    const auto it = by_name.find(r.name());
    if (it == by_name.end()) {
      ++result.only_now;
      continue;
    }
    const Record& old = *it->second;
    by_name.erase(it);
    if (old.status == CellStatus::done && r.status == CellStatus::done)
      pairs.push_back({&old, &r});
    else if (old.status != r.status)
      result.changes.push_back({r.name(), "status " + status_name(old.status) + " -> " + status_name(r.status), 0, 0, 0,
                                old.status == CellStatus::done});
  }
  result.only_before = by_name.size();
  result.compared = pairs.size();
  result.machine_factor = machine_factor(pairs);
  for (const Pair& p : pairs) {
    compare_times(p, false, result.machine_factor, result.changes);
    compare_times(p, true, result.machine_factor, result.changes);
    compare_errors(p, result.changes);
    compare_counters(p, result.changes);
  }
  return result;
}

}  // namespace opaline
