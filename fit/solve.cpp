#include "fit/solve.h"

#include "fit/residuals/image_residual.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/stopwatch.h"

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <cmath>

namespace opaline {
namespace {

using NoiseSd = std::vector<std::array<double, 3>>;

struct Problem {
  const std::vector<FitTarget>& targets;
  const ProfileInfo& profile;
  const SolveSettings& settings;
  ParameterBounds bounds;

  std::unique_ptr<ceres::Problem> build(ParameterVector& p, const NoiseSd& sd) const {
    auto problem = std::make_unique<ceres::Problem>();
    for (std::size_t t = 0; t < targets.size(); ++t)
      for (int c = 0; c < 3; ++c)
        problem->AddResidualBlock(
            new ImageResidual(targets[t].op, targets[t].of(c), profile, c, sd[t][static_cast<std::size_t>(c)]), nullptr,
            &p[static_cast<std::size_t>(c)], &p[static_cast<std::size_t>(c) + 3], &p[eta_index]);
    for (int i = 0; i < parameter_count; ++i) {
      double* block = &p[static_cast<std::size_t>(i)];
      if (!settings.free.is_free(i)) {
        problem->SetParameterBlockConstant(block);
        continue;
      }
      problem->SetParameterLowerBound(block, 0, bounds.lower(i));
      problem->SetParameterUpperBound(block, 0, bounds.upper(i));
    }
    return problem;
  }
};

ParameterBounds searched_bounds(const std::vector<FitTarget>& targets, ParameterBounds bounds) {
  for (const FitTarget& target : targets)
    bounds.sigma_max = std::min(bounds.sigma_max, 1 / std::sqrt(target.op.radial.x_0()));
  return bounds;
}

StartRecord run_start(const Problem& problem, const ParameterVector& from, const NoiseSd& sd) {
  StartRecord record{from, from};
  const auto ceres_problem = problem.build(record.to, sd);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = problem.settings.max_iterations;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-14;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, ceres_problem.get(), &summary);
  record.cost = summary.final_cost;
  record.converged = summary.termination_type == ceres::CONVERGENCE;
  record.message = summary.message;
  for (const ceres::IterationSummary& iteration : summary.iterations) record.history.push_back(iteration.cost);
  return record;
}

double radical_inverse(std::uint64_t n, unsigned base) {
  double value = 0, digit = 1.0 / base;
  for (; n; n /= base, digit /= base) value += digit * static_cast<double>(n % base);
  return value;
}

/// The scene's material first; then points of a Halton sequence over mean free path (against the
/// object's size), albedo and eta, the same for every channel.
std::vector<ParameterVector> start_points(const Problem& problem, const ParameterVector& initial) {
  std::vector<ParameterVector> points{initial};
  const SolveSettings& s = problem.settings;
  const RadialBasis& radial = problem.targets.front().op.radial;
  const double size = radial.radius(radial.size() - 3);
  for (int i = 1; i < s.starts; ++i) {
    const std::uint64_t n = 16 + s.seed * 1000 + static_cast<std::uint64_t>(i);
    const double sigma_t = 5 / size * std::pow(200.0, radical_inverse(n, 2));
    const double one_minus_alpha = std::pow(10.0, -0.3 - 3.2 * radical_inverse(n, 3));
    ParameterVector p = initial;
    for (std::size_t c = 0; c < 3; ++c) {
      if (s.free.sigma_a) p[c] = std::log(sigma_t * one_minus_alpha);
      if (s.free.sigma_s_prime) p[c + 3] = std::log(sigma_t * (1 - one_minus_alpha));
    }
    const ParameterBounds& bounds = problem.bounds;
    if (s.free.eta) p[eta_index] = bounds.eta_min + (bounds.eta_max - bounds.eta_min) * radical_inverse(n, 5);
    points.push_back(p);
  }
  for (ParameterVector& p : points)
    for (int i = 0; i < parameter_count; ++i)
      if (s.free.is_free(i))
        p[static_cast<std::size_t>(i)] =
            std::clamp(p[static_cast<std::size_t>(i)], problem.bounds.lower(i), problem.bounds.upper(i));
  return points;
}

/// Squared residual of every target and channel, in the target's units, at parameters p.
NoiseSd squared_residuals(const Problem& problem, const ParameterVector& p) {
  NoiseSd squares(problem.targets.size());
  for (std::size_t t = 0; t < squares.size(); ++t)
    for (int c = 0; c < 3; ++c) {
      const ImageResidual residual(problem.targets[t].op, problem.targets[t].of(c), problem.profile, c, 1.0);
      std::vector<double> r(static_cast<std::size_t>(residual.num_residuals()));
      const double* blocks[3] = {&p[static_cast<std::size_t>(c)], &p[static_cast<std::size_t>(c) + 3], &p[eta_index]};
      residual.Evaluate(blocks, r.data(), nullptr);
      double sum = problem.targets[t].of(c).constant[static_cast<std::size_t>(c)];
      for (const double value : r) sum += value * value;
      squares[t][static_cast<std::size_t>(c)] = sum;
    }
  return squares;
}

/// Noise before anything is known: a hundredth of each channel's RMS, so that channels count alike.
NoiseSd initial_noise(const std::vector<FitTarget>& targets) {
  NoiseSd sd(targets.size());
  for (std::size_t t = 0; t < targets.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c)
      sd[t][c] = 0.01 * std::sqrt(std::max(targets[t].tau[c], 1e-300) / static_cast<double>(targets[t].op.rows()));
  return sd;
}

NoiseSd estimated_noise(const Problem& problem, const ParameterVector& p) {
  NoiseSd sd = squared_residuals(problem, p);
  const int free =
      3 * (problem.settings.free.sigma_a + problem.settings.free.sigma_s_prime) + problem.settings.free.eta;
  const double per_channel = static_cast<double>(free) / (3.0 * static_cast<double>(sd.size()));
  for (std::size_t t = 0; t < sd.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      const double freedom = std::max(1.0, static_cast<double>(problem.targets[t].op.rows()) - per_channel);
      const double floor =
          1e-12 * std::sqrt(problem.targets[t].tau[c] / static_cast<double>(problem.targets[t].op.rows()));
      sd[t][c] = std::max({std::sqrt(sd[t][c] / freedom), floor, 1e-150});
    }
  return sd;
}

Eigen::MatrixXd whitened_jacobian(const Problem& problem, ParameterVector p, const NoiseSd& sd) {
  const auto ceres_problem = problem.build(p, sd);
  ceres::Problem::EvaluateOptions options;
  for (double& block : p) options.parameter_blocks.push_back(&block);
  ceres::CRSMatrix sparse;
  ceres_problem->Evaluate(options, nullptr, nullptr, nullptr, &sparse);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(sparse.num_rows, parameter_count);
  for (int row = 0; row < sparse.num_rows; ++row)
    for (int k = sparse.rows[static_cast<std::size_t>(row)]; k < sparse.rows[static_cast<std::size_t>(row) + 1]; ++k)
      dense(row, sparse.cols[static_cast<std::size_t>(k)]) = sparse.values[static_cast<std::size_t>(k)];
  return dense;
}

double half_chi_squared(const Problem& problem, const ParameterVector& p, const NoiseSd& sd) {
  const NoiseSd squares = squared_residuals(problem, p);
  double sum = 0;
  for (std::size_t t = 0; t < sd.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) sum += squares[t][c] / (sd[t][c] * sd[t][c]);
  return sum / 2;
}

/// How much worse than the solution every start ended, by the noise that the solution shows.
void compare_starts(const Problem& problem, Solution& solution) {
  const double least = half_chi_squared(problem, solution.parameters, solution.noise_sd);
  for (StartRecord& start : solution.starts)
    start.excess = half_chi_squared(problem, start.to, solution.noise_sd) - least;
}

void measure_residual(const Problem& problem, Solution& solution) {
  const NoiseSd squares = squared_residuals(problem, solution.parameters);
  double sum = 0, target = 0, count = 0;
  for (std::size_t t = 0; t < squares.size(); ++t)
    for (std::size_t c = 0; c < 3; ++c) {
      sum += squares[t][c];
      target += problem.targets[t].tau[c];
      count += static_cast<double>(problem.targets[t].op.rows());
    }
  solution.rmse = std::sqrt(sum / count);
  solution.relative_rmse = target > 0 ? std::sqrt(sum / target) : 0;
}

}  // namespace

void check_target(const Image& target, const Scene& scene, const std::string& name) {
  if (target.width != scene.film.width || target.height != scene.film.height)
    throw InputError(name, "",
                     fmt::format("is {} x {} pixels, but the scene's film is {} x {}", target.width, target.height,
                                 scene.film.width, scene.film.height));
  for (const char* channel : {"R", "G", "B"})
    if (target.channel(channel) < 0)
      throw InputError(name, "", "needs the channels R, G, B; it has " + join_names(target.channels));
}

FitTarget make_target(TransportOperator op, const Image& target, const std::string& name) {
  const std::array<int, 3> rgb = {target.channel("R"), target.channel("G"), target.channel("B")};
  Image picture(target.width, target.height, {"R", "G", "B"});
  for (const std::uint32_t pixel : op.pixels)
    for (std::size_t c = 0; c < 3; ++c) {
      const float value = target.data[pixel * target.channels.size() + static_cast<std::size_t>(rgb[c])];
      if (!std::isfinite(value))
        throw InputError(name,
                         fmt::format("pixel ({}, {}) channel {}", pixel % static_cast<std::uint32_t>(op.width),
                                     pixel / static_cast<std::uint32_t>(op.width), "RGB"[c]),
                         "is not finite; leave such pixels out with a --mask image");
      picture.data[pixel * 3u + c] = value;
    }
  if (op.pixels.empty()) throw InputError(name, "", "no pixel takes part: the object is out of view or masked");
  FitTarget result{std::move(op), {}, {}};
  for (const NormalEquations& equations : normal_equations(result.op, picture)) {
    result.reduced.push_back(reduce(equations));
    for (std::size_t c = 0; c < 3; ++c) result.tau[c] += equations.tau[c];
  }
  if (result.tau[0] + result.tau[1] + result.tau[2] == 0)
    throw InputError(name, "", "is black on every fitted pixel; the scene says that the object is seen there");
  return result;
}

Solution solve(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
               const SolveSettings& settings) {
  Stopwatch watch;
  const Problem problem{targets, profile, settings, searched_bounds(targets, settings.bounds)};
  const std::vector<ParameterVector> from = start_points(problem, to_parameters(initial, problem.bounds));
  const NoiseSd first_guess = initial_noise(targets);
  Solution solution;
  solution.bounds = problem.bounds;
  solution.starts.resize(from.size());
  tbb::parallel_for(std::size_t{0}, from.size(),
                    [&](std::size_t i) { solution.starts[i] = run_start(problem, from[i], first_guess); });
  for (std::size_t i = 0; i < from.size(); ++i) {
    solution.iterations += static_cast<int>(solution.starts[i].history.size());
    if (solution.starts[i].cost < solution.starts[static_cast<std::size_t>(solution.best_start)].cost)
      solution.best_start = static_cast<int>(i);
  }
  // Once more from the best, each channel weighted by the noise its residual shows.
  const ParameterVector best = solution.starts[static_cast<std::size_t>(solution.best_start)].to;
  const StartRecord polished = run_start(problem, best, estimated_noise(problem, best));
  solution.iterations += static_cast<int>(polished.history.size());
  solution.converged = polished.converged;
  solution.parameters = polished.to;
  solution.noise_sd = estimated_noise(problem, solution.parameters);
  solution.jacobian = whitened_jacobian(problem, solution.parameters, solution.noise_sd);
  measure_residual(problem, solution);
  compare_starts(problem, solution);
  solution.seconds = watch.lap();
  return solution;
}

}  // namespace opaline
