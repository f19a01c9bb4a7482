#include "fit/pivoted_cholesky.h"

namespace opaline {
namespace {

/// next(remaining): the pivot to take, or -1.
template <typename Next>
PivotedCholesky cholesky(const Eigen::MatrixXd& gram, Next next) {
  const Eigen::Index n = gram.rows();
  PivotedCholesky out;
  out.length = gram.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (out.length.array() > 0).select(out.length.array().inverse(), 0.0);
  Eigen::MatrixXd factor(n, n);
  Eigen::VectorXd remaining = (out.length.array() > 0).select(Eigen::ArrayXd::Ones(n), 0.0);
  for (Eigen::Index pivot; n > 0 && (pivot = next(remaining)) >= 0;) {
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

}  // namespace

PivotedCholesky pivoted_cholesky(const Eigen::MatrixXd& gram, double tolerance) {
  return cholesky(gram, [tolerance](const Eigen::VectorXd& remaining) {
    Eigen::Index pivot = 0;
    return remaining.maxCoeff(&pivot) > tolerance ? pivot : -1;
  });
}

PivotedCholesky ordered_cholesky(const Eigen::MatrixXd& gram, double tolerance) {
  Eigen::Index pivot = -1;
  return cholesky(gram, [tolerance, pivot](const Eigen::VectorXd& remaining) mutable {
    do {
      ++pivot;
    } while (pivot < remaining.size() && !(remaining[pivot] > tolerance));
    return pivot < remaining.size() ? pivot : -1;
  });
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
