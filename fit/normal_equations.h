// Sufficient statistics of a least-squares problem that is linear in the operator's columns, so that
// a fit never touches the pixels again:
//
//   sum_p (m_p . x - t_p)^2 = x^T G x - 2 x . b + tau,    G = M^T M,  b = M^T t,  tau = t . t
//
// and its reduction to a few residuals by pivoted Cholesky, G = L L^T with rank r < columns:
//
//                           = |L^T x - y|^2 + (tau - |y|^2),    L y = b.
#pragma once

#include "fit/transport_operator.h"

#include <Eigen/Core>

#include <vector>

namespace opaline {

struct NormalEquations {
  Eigen::MatrixXd gram;              ///< columns x columns, per light channel shared by the colours
  std::array<Eigen::VectorXd, 3> b;  ///< per colour channel
  std::array<double, 3> tau{};       ///< per colour channel
  std::size_t rows = 0;
};

/// One per light channel of the operator (1 or 3; with 3 only the matching colour is filled).
/// target: RGB image of the operator's film. Rows are summed in fixed blocks: the result does not
/// depend on the number of threads.
std::vector<NormalEquations> normal_equations(const TransportOperator& op, const Image& target);

/// L^T (rank x columns) and y per colour channel.
struct ReducedLeastSquares {
  Eigen::MatrixXd factor_transposed;
  std::array<Eigen::VectorXd, 3> y;
  std::array<double, 3> constant{};  ///< squared residual outside the columns' span, >= 0
};

/// Pivots are taken while the largest remaining diagonal of the column-normalised Gram matrix is
/// above `tolerance`.
ReducedLeastSquares reduce(const NormalEquations& equations, double tolerance = 1e-12);

}  // namespace opaline
