// Rank-revealing Cholesky factor of a Gram matrix whose columns may be of any size, zero or repeated.
#pragma once

#include <Eigen/Core>

#include <vector>

namespace opaline {

/// D^-1 G D^-1 = F F^T with D^2 the diagonal of G; the rows of F at the pivots are lower triangular.
struct PivotedCholesky {
  Eigen::VectorXd length;            ///< diagonal of D
  Eigen::MatrixXd factor;            ///< F, n x rank
  std::vector<Eigen::Index> pivots;  ///< which column each step took

  Eigen::Index rank() const { return factor.cols(); }
  /// L^T, rank x n, of G = L L^T.
  Eigen::MatrixXd factor_transposed() const { return (length.asDiagonal() * factor).transpose(); }
  /// y with L y = b.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const;
};

/// Pivots are taken while the largest remaining diagonal of D^-1 G D^-1 is above `tolerance`.
PivotedCholesky pivoted_cholesky(const Eigen::MatrixXd& gram, double tolerance);

/// Columns are taken as they come, those left out that have no more than `tolerance` remaining: for a matrix close to
/// diagonal, whose factor then is a triangle as it stands.
PivotedCholesky ordered_cholesky(const Eigen::MatrixXd& gram, double tolerance);

}  // namespace opaline
