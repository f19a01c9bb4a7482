// The inner loop of everything that sums over the operator's rows: products of dense matrices in double, on the
// instruction set at hand (Eigen's own are compiled for the oldest processor there is).
#pragma once

#include <Eigen/Core>

namespace opaline {

/// sum += a b. Columns of zeros at a's end, for 16 rows at a time, cost nothing: a lower triangle takes half the work.
void add_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& sum);

/// sum += a b^T; `lower`: above the diagonal the sum is wanted nowhere, and holds anything.
void add_outer_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, bool lower, Eigen::MatrixXd& sum);

}  // namespace opaline
