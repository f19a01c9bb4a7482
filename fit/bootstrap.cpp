#include "fit/bootstrap.h"

#include "render/stopwatch.h"

#include <tbb/parallel_for.h>
#include <Eigen/LU>

#include <algorithm>
#include <random>

namespace opaline {
namespace {

std::vector<Eigen::VectorXd> with_noise(std::vector<Eigen::VectorXd> data, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (Eigen::VectorXd& y : data)
    for (double& value : y) value += normal(random);
  return data;
}

Eigen::VectorXd as_row(const FitProblem& problem, const FitPoint& at, Eigen::Index columns) {
  Eigen::VectorXd row(columns);
  for (int i = 0; i < parameter_count; ++i) row[i] = at.material[static_cast<std::size_t>(i)];
  for (std::size_t t = 0; t < problem.targets().size(); ++t)
    if (const int column = scale_column(problem.targets(), t); column >= 0) row[column] = at.ln_scale[t];
  return row;
}

double quantile(std::vector<double> sorted, double q) {
  const double at = q * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const double t = at - static_cast<double>(below);
  return (1 - t) * sorted[below] + t * sorted[std::min(below + 1, sorted.size() - 1)];
}

void summarise(Bootstrap& b, const Eigen::VectorXd& solution) {
  const Eigen::Index n = b.draws.rows(), columns = b.draws.cols();
  b.sd = b.bias = Eigen::VectorXd::Zero(columns);
  b.low = b.high = solution;
  if (n < 2) return;
  for (Eigen::Index i = 0; i < columns; ++i) {
    const Eigen::VectorXd draws = b.draws.col(i);
    b.bias[i] = draws.mean() - solution[i];
    b.sd[i] = std::sqrt((draws.array() - draws.mean()).square().sum() / static_cast<double>(n - 1));
    std::vector<double> sorted(draws.begin(), draws.end());
    std::sort(sorted.begin(), sorted.end());
    b.low[i] = quantile(sorted, 0.025), b.high[i] = quantile(sorted, 0.975);
  }
}

}  // namespace

Bootstrap bootstrap(const FitProblem& problem, const Solution& solution, int repetitions, std::uint64_t seed,
                    const Eigen::MatrixXd& sensitivity) {
  Stopwatch watch;
  const FitPoint best{solution.parameters, solution.ln_scale};
  const std::vector<Eigen::VectorXd> expected = problem.expected_data(best);
  const Eigen::Index columns = solution.jacobian.cols();
  std::vector<FitEnd> ends(static_cast<std::size_t>(repetitions));
  tbb::parallel_for(0, repetitions, [&](int i) {
    const std::vector<Eigen::VectorXd> data = with_noise(expected, seed * 1000003 + static_cast<std::uint64_t>(i));
    ends[static_cast<std::size_t>(i)] = problem.with_data(data).minimise_quickly(best);
  });
  Bootstrap b;
  b.draws.resize(repetitions, columns);
  Eigen::Index kept = 0;
  for (const FitEnd& end : ends) {
    if (end.converged)
      b.draws.row(kept++) = as_row(problem, end.at, columns);
    else
      ++b.failed;
  }
  b.draws.conservativeResize(kept, columns);
  const Eigen::VectorXd centre = as_row(problem, best, columns);
  if (sensitivity.size() > 0) {
    const Eigen::MatrixXd moved = (b.draws.rowwise() - centre.transpose()).transpose();
    b.draws = sensitivity.partialPivLu().solve(moved).transpose().rowwise() + centre.transpose();
  }
  summarise(b, centre);
  b.seconds = watch.lap();
  return b;
}

}  // namespace opaline
