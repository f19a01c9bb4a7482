#include "fit/pivoted_cholesky.h"

namespace opaline {

PivotedCholesky pivoted_cholesky(const Eigen::MatrixXd& gram, double tolerance) {
  const Eigen::Index n = gram.rows();
  PivotedCholesky out;
  out.length = gram.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (out.length.array() > 0).select(out.length.array().inverse(), 0.0);
  Eigen::MatrixXd factor(n, n);
  Eigen::VectorXd remaining = (out.length.array() > 0).select(Eigen::ArrayXd::Ones(n), 0.0);
  Eigen::Index pivot = 0;
  while (out.pivots.size() < static_cast<std::size_t>(n) && remaining.maxCoeff(&pivot) > tolerance) {
    const auto k = static_cast<Eigen::Index>(out.pivots.size());
    Eigen::VectorXd column = gram.col(pivot).cwiseProduct(scale) * scale[pivot];
    column -= factor.leftCols(k) * factor.row(pivot).head(k).transpose();
    for (const Eigen::Index done : out.pivots) column[done] = 0;
    factor.col(k) = column / std::sqrt(remaining[pivot]);
    factor(pivot, k) = std::sqrt(remaining[pivot]);
    remaining -= factor.col(k).cwiseAbs2();
    out.pivots.push_back(pivot);
    for (const Eigen::Index done : out.pivots) remaining[done] = 0;
  }
  out.factor = factor.leftCols(static_cast<Eigen::Index>(out.pivots.size()));
  return out;
}

Eigen::VectorXd PivotedCholesky::solve(const Eigen::VectorXd& b) const {
  Eigen::VectorXd y = Eigen::VectorXd::Zero(rank());
  for (Eigen::Index k = 0; k < rank(); ++k) {
    const Eigen::Index p = pivots[static_cast<std::size_t>(k)];
    y[k] = (b[p] / length[p] - factor.row(p).head(k).dot(y.head(k))) / factor(p, k);
  }
  return y;
}

}  // namespace opaline
