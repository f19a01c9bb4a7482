// Samplers of the profiles: that they follow their densities, and what one costs.
#include "model/profiles/poles.h"
#include "model/profiles/profile.h"
#include "model/transport/split_mix.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

namespace opaline::bench {
namespace {

double uniform(SplitMix& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

/// (chi^2 - bins + 1)/sqrt(2 bins - 2) of samples over bins of equal flux, by the cumulative at the bins' edges.
double chi_squared_z(const Profile& profile, std::size_t count) {
  constexpr std::size_t bins = 1000;
  // Edges by the sampler itself would prove nothing: bisection on the cumulative.
  std::vector<double> edges;
  for (std::size_t i = 1; i < bins; ++i) {
    const double wanted = profile.total() * static_cast<double>(i) / bins;
    double low = -60, high = 60;
    while (high - low > 1e-13) {
      const double middle = 0.5 * (low + high);
      (profile.cumulative(std::exp(middle)) < wanted ? low : high) = middle;
    }
    edges.push_back(std::exp(low));
  }
  std::vector<double> hits(bins, 0);
  SplitMix random{11};
  for (std::size_t i = 0; i < count; ++i) {
    const double r = profile.sample(uniform(random));
    hits[static_cast<std::size_t>(std::ranges::upper_bound(edges, r) - edges.begin())] += 1;
  }
  const double expected = static_cast<double>(count) / bins;
  double chi_squared = 0;
  for (const double n : hits) chi_squared += (n - expected) * (n - expected) / expected;
  return (chi_squared - (bins - 1)) / std::sqrt(2.0 * (bins - 1));
}

/// Median of processor time, which other programs on the machine disturb less than the clock.
double nanoseconds_a_sample(const Profile& profile, int runs) {
  constexpr int count = 200000;
  double sum = profile.sample(0.5);  // makes the table, if there is one
  std::vector<double> seconds;
  for (int run = 0; run < runs; ++run) {
    SplitMix random{5};
    const std::clock_t start = std::clock();
    for (int i = 0; i < count; ++i) sum += profile.sample(uniform(random));
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
  }
  std::ranges::sort(seconds);
  return sum < 0 ? 0 : seconds[seconds.size() / 2] / count * 1e9;
}

/// The most steps of Newton's method that sample_pole takes, and their mean, over sigma z from 0 to 1e6.
Figure pole_steps() {
  SplitMix random{3};
  int most = 0;
  double sum = 0;
  const int count = 1000000;
  for (int i = 0; i < count; ++i) {
    const double sigma = i % 10 == 0 ? 0 : std::exp(-14 + 28 * uniform(random));
    const double xi = i % 2 ? uniform(random) : 1 - std::exp(-36.7 * uniform(random));
    const PoleSample sample = sample_pole_counted(1, sigma, std::min(xi, 1 - 0x1p-53));
    most = std::max(most, sample.steps);
    sum += sample.steps;
  }
  return {"steps of the pole's solve, worst",
          static_cast<double>(most),
          8,
          true,
          "",
          fmt::format("{:.2f} on average over 1e6 (sigma z, xi)", sum / count)};
}

}  // namespace

std::vector<Figure> model_figures(int runs, std::size_t samples) {
  std::vector<Figure> figures = {pole_steps()};
  const Medium<double> medium{0.05, 1, 1.3};
  for (const ProfileInfo& info : profiles()) {
    if (!info.needs_medium_alone()) continue;
    ProfileParameters parameters;
    for (const ProfileParameter& p : info.parameters) {
      if (p.name == "thickness_mm") parameters[p.name] = 3.0;
    }
    const auto profile = info.make(medium, parameters);
    figures.push_back({"sample " + info.name, nanoseconds_a_sample(*profile, runs),
                       info.name == "standard_dipole" ? 80.0 : 0.0, true, "ns", ""});
    figures.push_back({"  chi-squared of its samples, |z|", std::abs(chi_squared_z(*profile, samples)), 4, true, "",
                       fmt::format("{:.0e} samples in 1000 bins of equal flux", static_cast<double>(samples))});
  }
  return figures;
}

}  // namespace opaline::bench
