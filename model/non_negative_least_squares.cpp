#include "model/non_negative_least_squares.h"

#include <Eigen/Dense>

#include <algorithm>
#include <vector>

namespace opaline {
namespace {

/// The largest step from x towards a solution that keeps the active entries >= 0.
double feasible_step(const Eigen::VectorXd& x, const Eigen::VectorXd& target, const std::vector<int>& active) {
  double step = 1;
  for (std::size_t k = 0; k < active.size(); ++k) {
    const double from = x[active[k]], to = target[static_cast<int>(k)];
    if (to < 0) step = std::min(step, from / (from - to));
  }
  return step;
}

Eigen::VectorXd solve_subset(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, const std::vector<int>& active) {
  return a(Eigen::all, active).colPivHouseholderQr().solve(b);
}

/// Least squares on the active entries, dropping the ones that would turn negative until none does. False, with
/// nothing changed, if the newest one itself would: its gradient was rounding.
bool refine(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, std::vector<int>& active, Eigen::VectorXd& x) {
  for (bool first = true; !active.empty(); first = false) {
    const Eigen::VectorXd target = solve_subset(a, b, active);
    if (first && target[target.size() - 1] <= 0) return active.pop_back(), false;
    const double step = feasible_step(x, target, active);
    for (std::size_t k = 0; k < active.size(); ++k) {
      double& value = x[active[k]];
      const double way = target[static_cast<int>(k)] - value;
      value += step * way;
      if (step < 1 && way < 0 && value < 1e-14 * -way) value = 0;
    }
    if (step == 1) break;
    std::erase_if(active, [&](int i) { return x[i] <= 0; });
  }
  return true;
}

}  // namespace

Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double tolerance) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
  std::vector<int> active;
  const double small = tolerance * (a.transpose() * b).cwiseAbs().maxCoeff();
  for (int round = 0; round < 3 * a.cols(); ++round) {
    Eigen::VectorXd gradient = a.transpose() * (b - a * x);
    for (const int i : active) gradient[i] = 0;
    int best = 0;
    if (gradient.maxCoeff(&best) <= small) break;
    active.push_back(best);
    if (!refine(a, b, active, x)) break;
  }
  return x;
}

}  // namespace opaline
