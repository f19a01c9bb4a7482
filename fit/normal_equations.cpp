#include "fit/normal_equations.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace opaline {
namespace {

constexpr std::size_t blocks = 16;  // fixed, so that sums do not depend on the thread count
constexpr std::size_t rows_at_once = 192;

struct Block {
  Eigen::MatrixXd gram;
  std::array<Eigen::VectorXd, 3> b;
  std::array<double, 3> tau{};
};

Block sum_block(const TransportOperator& op, const Image& target, int light, const std::vector<int>& colours,
                std::size_t begin, std::size_t end) {
  const auto n = static_cast<Eigen::Index>(op.columns());
  Block block;
  block.gram = Eigen::MatrixXd::Zero(n, n);
  for (const int c : colours) block.b[static_cast<std::size_t>(c)] = Eigen::VectorXd::Zero(n);
  for (std::size_t first = begin; first < end; first += rows_at_once) {
    const std::size_t count = std::min(rows_at_once, end - first);
    Eigen::MatrixXd m(n, static_cast<Eigen::Index>(count));
    for (std::size_t i = 0; i < count; ++i)
      m.col(static_cast<Eigen::Index>(i)) =
          Eigen::Map<const Eigen::VectorXf>(op.row(first + i, light), n).cast<double>();
    block.gram.selfadjointView<Eigen::Lower>().rankUpdate(m);
    for (const int c : colours) {
      Eigen::VectorXd t(static_cast<Eigen::Index>(count));
      for (std::size_t i = 0; i < count; ++i)
        t[static_cast<Eigen::Index>(i)] =
            static_cast<double>(target.data[static_cast<std::size_t>(op.pixels[first + i]) * target.channels.size() +
                                            static_cast<std::size_t>(c)]);
      block.b[static_cast<std::size_t>(c)] += m * t;
      block.tau[static_cast<std::size_t>(c)] += t.squaredNorm();
    }
  }
  return block;
}

}  // namespace

std::vector<NormalEquations> normal_equations(const TransportOperator& op, const Image& target) {
  std::vector<NormalEquations> result;
  for (int light = 0; light < op.light_channels; ++light) {
    const std::vector<int> colours = op.light_channels == 1 ? std::vector<int>{0, 1, 2} : std::vector<int>{light};
    std::vector<Block> partial(blocks);
    tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t i) {
      partial[i] = sum_block(op, target, light, colours, op.rows() * i / blocks, op.rows() * (i + 1) / blocks);
    });
    NormalEquations equations;
    equations.rows = op.rows();
    equations.gram = partial[0].gram;
    equations.b = partial[0].b;
    equations.tau = partial[0].tau;
    for (std::size_t i = 1; i < blocks; ++i) {
      equations.gram += partial[i].gram;
      for (const int c : colours) {
        equations.b[static_cast<std::size_t>(c)] += partial[i].b[static_cast<std::size_t>(c)];
        equations.tau[static_cast<std::size_t>(c)] += partial[i].tau[static_cast<std::size_t>(c)];
      }
    }
    equations.gram.triangularView<Eigen::StrictlyUpper>() = equations.gram.transpose();
    result.push_back(std::move(equations));
  }
  return result;
}

ReducedLeastSquares reduce(const NormalEquations& equations, double tolerance) {
  const Eigen::Index n = equations.gram.rows();
  // Columns of unit length: a node few pixels reach counts as much as any other.
  const Eigen::VectorXd length = equations.gram.diagonal().cwiseMax(0.0).cwiseSqrt();
  const Eigen::VectorXd scale = (length.array() > 0).select(length.array().inverse(), 0.0);
  Eigen::MatrixXd factor(n, n);  // rows of L^T are its columns until the rank is known
  Eigen::VectorXd remaining = (length.array() > 0).select(Eigen::ArrayXd::Ones(n), 0.0);
  std::vector<Eigen::Index> pivots;
  Eigen::Index pivot = 0;
  while (static_cast<Eigen::Index>(pivots.size()) < n && remaining.maxCoeff(&pivot) > tolerance) {
    const auto k = static_cast<Eigen::Index>(pivots.size());
    Eigen::VectorXd column = equations.gram.col(pivot).cwiseProduct(scale) * scale[pivot];
    column -= factor.leftCols(k) * factor.row(pivot).head(k).transpose();
    for (const Eigen::Index done : pivots) column[done] = 0;
    factor.col(k) = column / std::sqrt(remaining[pivot]);
    factor(pivot, k) = std::sqrt(remaining[pivot]);
    remaining -= factor.col(k).cwiseAbs2();
    pivots.push_back(pivot);
    for (const Eigen::Index done : pivots) remaining[done] = 0;
  }
  const auto rank = static_cast<Eigen::Index>(pivots.size());
  ReducedLeastSquares reduced;
  for (std::size_t c = 0; c < 3; ++c) {
    if (equations.b[c].size() == 0) continue;
    const Eigen::VectorXd b = equations.b[c].cwiseProduct(scale);
    Eigen::VectorXd& y = reduced.y[c] = Eigen::VectorXd::Zero(rank);
    for (Eigen::Index k = 0; k < rank; ++k) {
      const Eigen::Index p = pivots[static_cast<std::size_t>(k)];
      y[k] = (b[p] - factor.row(p).head(k).dot(y.head(k))) / factor(p, k);
    }
    reduced.constant[c] = std::max(0.0, equations.tau[c] - y.squaredNorm());
  }
  // Undo the scaling: x of the caller multiplies the original columns.
  reduced.factor_transposed = (length.asDiagonal() * factor.leftCols(rank)).transpose();
  return reduced;
}

}  // namespace opaline
