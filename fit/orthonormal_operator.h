// The operator's matrix as Q L^T with orthonormal columns Q: the same pictures from a few hundred numbers a pixel
// fewer.
//
//   M = Q L^T,  Q^T Q = 1,   sum_p (m_p . x - t_p)^2 = |L^T x - Q^T t|^2 + |t|^2 - |Q^T t|^2
//
// So a fit with equal noise everywhere needs y = Q^T t and never touches the pixels again; noise that differs from
// pixel to pixel, or between channels, needs sums over the short rows of Q only (whitening.h). Found by pivoted
// Cholesky of the Gram matrix, twice (the second time makes Q orthonormal to rounding: "CholeskyQR2"). The first time
// it only has to find which columns depend on which: of a large picture some 8192 rows tell that, checked on others.
#pragma once

#include "fit/transport_operator.h"

#include <Eigen/Core>

#include <vector>

namespace opaline {

/// Per light channel of the operator (1 or 3).
struct OrthonormalOperator {
  std::vector<Eigen::MatrixXf> q;       ///< rank x rows: a column is a pixel
  std::vector<Eigen::MatrixXd> factor;  ///< L^T, rank x columns of the operator
  int reduced_in_full = 0;              ///< light channels for which a sample of the rows was not enough
};

/// Keeps all of M that is above the root of `tolerance` of each column's length. Sums run in fixed blocks: the result
/// does not depend on the number of threads.
OrthonormalOperator orthonormalise(const TransportOperator& op, double tolerance = 1e-12);

/// sum over the columns of `a` of weight * a_i b_i^T (all weights 1 if null), in fixed blocks.
Eigen::MatrixXd weighted_gram(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b, const float* weight);

/// Q^T v for v per pixel.
Eigen::VectorXd basis_sum(const Eigen::MatrixXf& q, const Eigen::VectorXd& v);

}  // namespace opaline
