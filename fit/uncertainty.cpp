#include "fit/uncertainty.h"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <cmath>
#include <limits>

namespace opaline {
namespace {

constexpr double normal_95 = 1.959963984540054;
constexpr double same_fit = 1.92;   // half the 95 % point of chi-squared with one degree of freedom
constexpr double largest_sd = 1e6;  // of ln sigma or eta: "nothing is known"

/// Columns of the Jacobian that are free: parameters, then scales. Of a grey picture R's alone.
std::vector<int> free_columns(const Solution& solution, const FreeParameters& free) {
  std::vector<int> columns;
  for (int i = 0; i < parameter_count; ++i)
    if (free.is_free(i) && !(solution.grey && i < eta_index && i % 3 != 0)) columns.push_back(i);
  for (int i = parameter_count; i < static_cast<int>(solution.jacobian.cols()); ++i) columns.push_back(i);
  return columns;
}

Eigen::MatrixXd picked(const Eigen::MatrixXd& jacobian, const std::vector<int>& columns) {
  Eigen::MatrixXd out(jacobian.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t k = 0; k < columns.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = jacobian.col(columns[k]);
  return out;
}

/// Inverse of J^T J after scaling to unit columns; eigenvalues are kept from falling to zero.
Eigen::MatrixXd invert(const Eigen::MatrixXd& jacobian, double& condition) {
  const Eigen::VectorXd length = jacobian.colwise().norm().transpose().cwiseMax(1 / largest_sd);
  const Eigen::MatrixXd scaled = jacobian * length.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() * scaled);
  const Eigen::VectorXd values = eigen.eigenvalues();
  condition = std::sqrt(values.maxCoeff() / std::max(values.minCoeff(), 1e-30));
  const Eigen::VectorXd inverse = values.cwiseMax(1e-16 * values.maxCoeff()).cwiseInverse();
  const Eigen::MatrixXd covariance = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  return length.cwiseInverse().asDiagonal() * covariance * length.cwiseInverse().asDiagonal();
}

bool at_bound(int i, double value, const ParameterBounds& bounds) {
  const double lo = bounds.lower(i), hi = bounds.upper(i), margin = 1e-6 * (hi - lo);
  return value < lo + margin || value > hi - margin;
}

/// Widens an interval to what the starts found that fits as well: the derivatives at one end of a
/// flat valley know nothing of its other end.
template <typename ValueOf>
void include_equal_fits(const Solution& solution, ParameterEstimate& e, const ValueOf& value_of) {
  for (const StartRecord& start : solution.starts) {
    if (!(start.excess < same_fit)) continue;
    e.low = std::min(e.low, value_of(start.to));
    e.high = std::max(e.high, value_of(start.to));
  }
}

/// Why an interval is no measurement, in words; empty if it is one.
std::string why_not(int i, double value, double sd, const ParameterEstimate& e, const ParameterBounds& bounds) {
  const bool is_eta = i == eta_index;
  if (at_bound(i, value, bounds)) return "it ended at a bound of its range";
  const bool wide = is_eta ? e.high - e.low > 0.5 * (bounds.eta_max - bounds.eta_min) : e.high > 2 * e.low;
  const bool wide_parabola =
      is_eta ? 2 * normal_95 * sd > 0.5 * (bounds.eta_max - bounds.eta_min) : 2 * normal_95 * sd > std::log(2.0);
  if (e.interval == "parabola" ? wide_parabola : wide)
    return is_eta ? "its 95 % interval covers more than half of its range"
                  : "its 95 % interval is wider than a factor of 2";
  return wide ? "values that other starts found fit as well" : "";
}

ParameterEstimate estimate(int i, const Solution& solution, double sd, bool free) {
  const double value = solution.parameters[static_cast<std::size_t>(i)];
  const ParameterBounds& bounds = solution.bounds;
  ParameterEstimate e;
  e.value = natural_value(i, value);
  e.free = free;
  if (!e.free) {
    e.low = e.high = e.value;
    return e;
  }
  sd = std::min(sd, largest_sd);
  e.sd = i == eta_index ? sd : e.value * sd;
  e.low = natural_value(i, std::max(value - normal_95 * sd, bounds.lower(i)));
  e.high = natural_value(i, std::min(value + normal_95 * sd, bounds.upper(i)));
  include_equal_fits(solution, e,
                     [i](const ParameterVector& p) { return natural_value(i, p[static_cast<std::size_t>(i)]); });
  // Rounding, not the picture, would then say what is known.
  const bool too_few = solution.freedom + static_cast<double>(solution.prior_rows) < 0;
  e.reason = too_few ? "there are fewer values than unknowns" : why_not(i, value, sd, e, bounds);
  e.identifiable = e.reason.empty();
  return e;
}

double alpha_of(const ParameterVector& p, int c) {
  return 1 / (1 + std::exp(p[static_cast<std::size_t>(c)] - p[static_cast<std::size_t>(c) + 3]));
}

/// alpha' = 1 / (1 + exp(ln sigma_a - ln sigma_s')): first-order propagation.
ParameterEstimate derive_alpha(int c, const Solution& solution, const Eigen::MatrixXd& covariance) {
  const double variance = covariance(c, c) + covariance(c + 3, c + 3) - 2 * covariance(c, c + 3);
  ParameterEstimate e;
  e.value = alpha_of(solution.parameters, c);
  e.sd = e.value * (1 - e.value) * std::min(std::sqrt(std::max(variance, 0.0)), largest_sd);
  e.low = std::max(0.0, e.value - normal_95 * e.sd);
  e.high = std::min(1.0, e.value + normal_95 * e.sd);
  include_equal_fits(solution, e, [c](const ParameterVector& p) { return alpha_of(p, c); });
  // As a share of absorption: 1 - alpha' is what tells materials apart.
  const double most = std::max({e.high - e.value, e.value - e.low, normal_95 * e.sd});
  e.identifiable = most < 0.5 * std::max(1 - e.value, 0.02);
  if (!e.identifiable) e.reason = "its 95 % interval is wider than half of 1 - alpha'";
  return e;
}

void add_notes(Uncertainty& u, bool converged) {
  if (!converged) u.notes.emplace_back("the solver did not converge: the intervals are not to be trusted");
  for (int i = 0; i < parameter_count; ++i)
    for (int j = 0; j < i; ++j)
      if (std::abs(u.correlation(i, j)) > 0.9 && u.parameters[static_cast<std::size_t>(i)].identifiable &&
          u.parameters[static_cast<std::size_t>(j)].identifiable)
        u.notes.push_back(fmt::format("{} and {} trade off (correlation {:+.3f}): their errors are not independent",
                                      parameter_name(j), parameter_name(i), u.correlation(i, j)));
  int lost = 0, alpha = 0;
  for (int c = 0; c < 3; ++c) {
    lost += !u.parameters[static_cast<std::size_t>(c)].identifiable ||
            !u.parameters[static_cast<std::size_t>(c) + 3].identifiable;
    alpha += u.alpha_prime[static_cast<std::size_t>(c)].identifiable;
  }
  if (lost == 3 && alpha > 0)
    u.notes.emplace_back(
        "the picture determines the albedo alpha' but not the coefficients apart: add a beam, an edge or a side light");
}

/// Names what a prior says rather than the picture: without it the interval is more than three times as wide.
void note_priors(const Solution& solution, const std::vector<int>& columns, Uncertainty& u) {
  if (solution.prior_rows == 0) return;
  const Eigen::Index rows = solution.jacobian.rows();
  const Eigen::MatrixXd data = solution.jacobian.topRows(rows - solution.prior_rows),
                        prior = solution.jacobian.bottomRows(solution.prior_rows);
  double condition = 0;
  const Eigen::MatrixXd alone = invert(picked(data, columns), condition);
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    if (columns[k] >= parameter_count || prior.col(columns[k]).norm() == 0) continue;
    if (alone(i, i) > 9 * u.covariance(columns[k], columns[k]))
      u.notes.push_back(fmt::format("{} comes from its prior: the pictures alone leave it {:.2g} times as wide",
                                    parameter_name(columns[k]),
                                    std::sqrt(alone(i, i) / u.covariance(columns[k], columns[k]))));
  }
}

}  // namespace

void include_starts_and_judge(const Solution& solution, Uncertainty& u) {
  for (int i = 0; i < parameter_count; ++i) {
    ParameterEstimate& e = u.parameters[static_cast<std::size_t>(i)];
    if (!e.free || e.interval == "parabola") continue;
    const int source = solution.grey && i < eta_index ? i - i % 3 : i;
    include_equal_fits(solution, e, [source](const ParameterVector& p) {
      return natural_value(source, p[static_cast<std::size_t>(source)]);
    });
    e.reason = why_not(source, solution.parameters[static_cast<std::size_t>(source)],
                       std::sqrt(u.covariance(source, source)), e, solution.bounds);
    e.identifiable = e.reason.empty();
  }
}

Uncertainty uncertainty(const Solution& solution, const FreeParameters& free_parameters) {
  Uncertainty u;
  const std::vector<int> free = free_columns(solution, free_parameters);
  const Eigen::MatrixXd inverse = invert(picked(solution.jacobian, free), u.condition);
  const Eigen::Index columns = std::max<Eigen::Index>(solution.jacobian.cols(), parameter_count);
  u.covariance = Eigen::MatrixXd::Zero(columns, columns);
  for (std::size_t a = 0; a < free.size(); ++a)
    for (std::size_t b = 0; b < free.size(); ++b)
      u.covariance(free[a], free[b]) = inverse(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
  u.correlation = Eigen::MatrixXd::Identity(columns, columns);
  for (const int i : free)
    for (const int j : free)
      if (i != j) u.correlation(i, j) = u.covariance(i, j) / std::sqrt(u.covariance(i, i) * u.covariance(j, j));
  for (int i = 0; i < parameter_count; ++i) {
    const int source = solution.grey && i < eta_index ? i - i % 3 : i;
    u.parameters[static_cast<std::size_t>(i)] =
        estimate(source, solution, std::sqrt(u.covariance(source, source)), free_parameters.is_free(source));
  }
  for (int c = 0; c < 3; ++c)
    u.alpha_prime[static_cast<std::size_t>(c)] = derive_alpha(solution.grey ? 0 : c, solution, u.covariance);
  for (Eigen::Index i = parameter_count; i < columns; ++i) u.scale_sd.push_back(std::sqrt(u.covariance(i, i)));
  add_notes(u, solution.converged);
  note_priors(solution, free, u);
  return u;
}

}  // namespace opaline
