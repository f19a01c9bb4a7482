#include "fit/profile_interval.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr double normal_95 = 1.959963984540054;
constexpr double threshold = 1.920729410347062;  // half the 95 % point of chi-squared with one degree of freedom

struct Side {
  const FitProblem& problem;
  FitPoint best;
  double least;
  const Eigen::MatrixXd& covariance;
  int i;

  /// Half chi-squared above the solution's with the parameter at x, the others where they like best.
  double excess(double x) const {
    FitPoint from = best;
    const double moved = x - best.material[static_cast<std::size_t>(i)];
    for (int j = 0; j < parameter_count; ++j) {
      const double along = covariance(i, i) > 0 ? covariance(j, i) / covariance(i, i) : 0;
      double& value = from.material[static_cast<std::size_t>(j)];
      if (problem.is_free(j))
        value =
            std::clamp(value + (j == i ? moved : along * moved), problem.bounds().lower(j), problem.bounds().upper(j));
    }
    const double straight = problem.half_chi_squared(problem.minimise_quickly(from, i).at) - least;
    return std::max(straight, 0.0);
  }

  /// The end of the interval on this side; `moved` says whether the parabola's was not good enough.
  double end(double sd, double sign, bool& moved) const {
    const double value = best.material[static_cast<std::size_t>(i)];
    const double bound = sign < 0 ? problem.bounds().lower(i) : problem.bounds().upper(i);
    const auto inside = [&](double x) { return sign < 0 ? std::max(x, bound) : std::min(x, bound); };
    double x = inside(value + sign * normal_95 * sd), near = value, far = 0;
    bool bracketed = false;  // the threshold lies between near and far
    for (int step = 0; step < 20; ++step) {
      const double f = excess(x);
      if (std::abs(f - threshold) < (step == 0 ? 0.1 : 0.02) * threshold) return x;
      moved = true;
      if (x == bound && f < threshold) return bound;
      if (f < threshold)
        near = x;
      else
        far = x, bracketed = true;
      // The parabola through value and x, kept inside the bracket; halving it where that would be slow.
      x = inside(value + (x - value) * std::clamp(std::sqrt(threshold / std::max(f, 1e-6)), 0.2, 5.0));
      if (bracketed &&
          (std::abs(x - value) >= std::abs(far - value) || std::abs(x - value) <= std::abs(near - value) || step > 5))
        x = 0.5 * (near + far);
      if (bracketed && std::abs(far - near) < 1e-9) return x;
    }
    return x;
  }
};

}  // namespace

void profile_intervals(const FitProblem& problem, const Solution& solution, Uncertainty& u) {
  const FitPoint best{solution.parameters, solution.ln_scale};
  const double least = problem.half_chi_squared(best);
  tbb::parallel_for(0, parameter_count, [&](int i) {
    ParameterEstimate& e = u.parameters[static_cast<std::size_t>(i)];
    if (!problem.is_free(i)) return;
    const Side side{problem, best, least, u.covariance, i};
    const double sd = std::min(std::sqrt(u.covariance(i, i)), 1e3);
    bool moved = false;
    const double low = side.end(sd, -1, moved), high = side.end(sd, 1, moved);
    if (!moved) return;
    e.low = natural_value(i, low), e.high = natural_value(i, high);
    e.interval = "profile";
  });
  include_starts_and_judge(solution, u);
}

}  // namespace opaline
