// Least squares with non-negative unknowns, by Lawson & Hanson's active sets ("Solving Least Squares Problems", 1974,
// chapter 23).
#pragma once

#include <Eigen/Core>

namespace opaline {

/// min |a x - b| over x >= 0; a has at most a few hundred columns, of similar length. Stops when no unknown that is 0
/// would lower the residual with a gradient above `tolerance` times the largest at x = 0, or when rounding lets none
/// enter.
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b,
                                           double tolerance = 1e-12);

}  // namespace opaline
