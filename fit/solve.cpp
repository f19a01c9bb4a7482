#include "fit/solve.h"

#include "fit/noise_weights.h"
#include "fit/robust.h"
#include "fit/starts.h"
#include "render/stopwatch.h"

#include <tbb/parallel_for.h>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

StartRecord run_start(const FitProblem& problem, const ParameterVector& from) {
  FitPoint at{from, std::vector<double>(problem.targets().size(), 0.0)};
  problem.set_scales(at);
  const FitEnd end = problem.minimise(at);
  return {from, end.at.material, end.cost, 0, end.converged, end.message, end.history, end.at.ln_scale};
}

void run_starts(const FitProblem& problem, const ParameterVector& initial, Solution& solution) {
  const std::vector<ParameterVector> from = start_points(problem, initial);
  solution.starts.resize(from.size());
  tbb::parallel_for(std::size_t{0}, from.size(),
                    [&](std::size_t i) { solution.starts[i] = run_start(problem, from[i]); });
  for (std::size_t i = 0; i < from.size(); ++i) {
    solution.iterations += static_cast<int>(solution.starts[i].history.size());
    if (solution.starts[i].cost < solution.starts[static_cast<std::size_t>(solution.best_start)].cost)
      solution.best_start = static_cast<int>(i);
  }
}

/// Again from the best start, weighted by the noise: what its residual shows, or what is known at its signal.
FitPoint polish(const FitProblem& problem, FitPoint at, std::vector<Whitened>& weights, Solution& solution) {
  bool signal_counts = false;
  for (const FitTarget& target : problem.targets()) signal_counts |= target.noise.known && !target.noise.uniform();
  for (int round = 0; round < (signal_counts ? 2 : 1); ++round) {
    weights = weights_at(problem, at);
    const FitEnd end = problem.minimise(at);
    solution.iterations += static_cast<int>(end.history.size());
    solution.converged = end.converged;
    at = end.at;
  }
  weights = weights_at(problem, at);
  return at;
}

/// How much worse than the solution every start ended, by the noise that the solution shows.
void compare_starts(const FitProblem& problem, const FitPoint& at, Solution& solution) {
  const double least = problem.half_chi_squared(at);
  solution.chi_squared = 2 * least;
  for (StartRecord& start : solution.starts)
    start.excess = problem.half_chi_squared({start.to, start.ln_scale}) - least;
}

void measure_residual(const FitProblem& problem, const FitPoint& at, Solution& solution) {
  double sum = 0, target = 0, count = 0;
  for (std::size_t t = 0; t < problem.targets().size(); ++t) {
    const FitTarget& one = problem.targets()[t];
    sum += (fitted_rows(problem, at, t) - one.picture).squaredNorm();
    target += one.products.trace();
    count += static_cast<double>(one.rows()) * one.channels;
  }
  solution.rmse = std::sqrt(sum / count);
  solution.relative_rmse = target > 0 ? std::sqrt(sum / target) : 0;
  solution.freedom = count - free_count(problem);
}

void record_noise(const FitProblem& problem, const std::vector<Covariance>& noise, Solution& solution) {
  solution.minus_two_ln_likelihood = solution.chi_squared;
  for (std::size_t t = 0; t < noise.size(); ++t) {
    const Eigen::Vector3d sd = noise[t].diagonal().cwiseSqrt();
    const int n = problem.targets()[t].channels;
    const auto sd_of = [&](int c) { return sd[std::min(c, n - 1)]; };
    solution.noise_sd.push_back({sd_of(0), sd_of(1), sd_of(2)});
    solution.noise_correlation.emplace_back(sd.cwiseInverse().asDiagonal() * noise[t] * sd.cwiseInverse().asDiagonal());
    if (!problem.targets()[t].noise.known)
      solution.minus_two_ln_likelihood +=
          static_cast<double>(problem.targets()[t].rows()) * std::log(noise[t].topLeftCorner(n, n).determinant());
  }
}

}  // namespace

bool rough_noise(const std::vector<FitTarget>& targets) {
  return std::any_of(targets.begin(), targets.end(), [](const FitTarget& t) { return t.noise.known && t.noise.rough; });
}

Solution solve(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
               const SolveSettings& settings) {
  Stopwatch watch;
  Solution solution;
  solution.bounds = searched_bounds(targets, settings.bounds);
  std::vector<Whitened>& weights = solution.whitened = first_weights(targets);
  const FitProblem problem(targets, weights, profile, settings, solution.bounds);
  run_starts(problem, to_parameters(initial, solution.bounds), solution);
  const StartRecord& best = solution.starts[static_cast<std::size_t>(solution.best_start)];
  FitPoint at = polish(problem, {best.to, best.ln_scale}, weights, solution);
  std::vector<Covariance> noise = noise_at(problem, at);
  const bool squares = settings.loss.kind == RobustLoss::Kind::squares;
  if (!squares || rough_noise(targets)) {
    RobustFit robust = robust_fit(targets, profile, settings, solution.bounds, at);
    weights = std::move(robust.whitened);
    noise = std::move(robust.noise);
    at = robust.end.at;
    solution.jacobian = std::move(robust.jacobian);
    if (!squares) solution.pixel_weight_share = std::move(robust.mean_weight);
    solution.converged = robust.settled;
    solution.iterations += static_cast<int>(robust.end.history.size());
  } else {
    solution.jacobian = problem.jacobian(at);
    solution.prior_rows = static_cast<Eigen::Index>(settings.priors.size());
  }
  compare_starts(problem, at, solution);
  measure_residual(problem, at, solution);
  record_noise(problem, noise, solution);
  solution.grey = all_grey(targets);
  if (solution.grey)
    for (std::size_t i = 0; i < eta_index; ++i) at.material[i] = at.material[i - i % 3];
  solution.parameters = at.material;
  solution.ln_scale = at.ln_scale;
  solution.seconds = watch.lap();
  return solution;
}

}  // namespace opaline
