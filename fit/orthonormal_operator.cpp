#include "fit/orthonormal_operator.h"

#include "fit/block_product.h"
#include "fit/pivoted_cholesky.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::MatrixXf;

constexpr std::size_t blocks = 16;  // fixed, so that sums do not depend on the thread count
constexpr std::size_t rows_at_once = 192;
constexpr std::size_t sample_rows = 8192;  // tell the rank: many times the columns
constexpr std::size_t check_rows = 512;

/// body(first, count) over pieces of [0, rows), in `blocks` tasks; sums of the tasks' results in order.
template <typename Body>
MatrixXd sum_over_rows(std::size_t rows, Index n, Index m, const Body& body) {
  std::vector<MatrixXd> partial(blocks, MatrixXd::Zero(n, m));
  tbb::parallel_for(std::size_t{0}, blocks, [&](std::size_t i) {
    const std::size_t end = rows * (i + 1) / blocks;
    for (std::size_t first = rows * i / blocks; first < end; first += rows_at_once)
      body(first, std::min(rows_at_once, end - first), partial[i]);
  });
  for (std::size_t i = 1; i < blocks; ++i) partial[0] += partial[i];
  return partial[0];
}

/// `count` rows of the operator, `step` apart, as columns.
MatrixXd columns_of(const TransportOperator& op, int light, std::size_t first, std::size_t count,
                    std::size_t step = 1) {
  const auto n = static_cast<Index>(op.columns());
  MatrixXd m(n, static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    m.col(static_cast<Index>(i)) = Eigen::Map<const Eigen::VectorXf>(op.row(first + i * step, light), n).cast<double>();
  return m;
}

MatrixXd symmetric(const MatrixXd& lower) { return lower.selfadjointView<Eigen::Lower>(); }

/// Of every `step`-th row.
MatrixXd operator_gram(const TransportOperator& op, int light, std::size_t step) {
  const auto n = static_cast<Index>(op.columns());
  const std::size_t rows = (op.rows() + step - 1) / step;
  return symmetric(sum_over_rows(rows, n, n, [&](std::size_t first, std::size_t count, MatrixXd& sum) {
    const MatrixXd m = columns_of(op, light, first * step, count, step);
    add_outer_product(m, m, true, sum);
  }));
}

/// Of the rows of the factor at the pivots: what takes the columns at the pivots to orthonormal ones.
MatrixXd inverse_triangle(const PivotedCholesky& cholesky) {
  const Index rank = cholesky.rank();
  MatrixXd triangle(rank, rank);
  for (Index k = 0; k < rank; ++k) {
    const Index p = cholesky.pivots[static_cast<std::size_t>(k)];
    triangle.row(k) = cholesky.length[p] * cholesky.factor.row(p);
  }
  return triangle.triangularView<Eigen::Lower>().solve(MatrixXd::Identity(rank, rank));
}

/// Rows of Q: `transform` times the pivots of the operator's. Q is written once, when both triangles have become one
/// matrix; the first Q exists by the block only, in double. Each pass costs rows x rank^2 flops, the Gram matrix as
/// many.
struct PivotRows {
  const TransportOperator& op;
  int light;
  std::vector<Index> pivots;
  MatrixXd transform;

  MatrixXd of(std::size_t first, std::size_t count) const {
    MatrixXd picked(static_cast<Index>(pivots.size()), static_cast<Index>(count));
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < pivots.size(); ++k)
        picked(static_cast<Index>(k), static_cast<Index>(i)) = static_cast<double>(op.row(first + i, light)[pivots[k]]);
    MatrixXd q = MatrixXd::Zero(transform.rows(), picked.cols());
    add_product(transform, picked, q);
    return q;
  }
  MatrixXd gram() const {
    const Index n = transform.rows();
    return symmetric(sum_over_rows(op.rows(), n, n, [&](std::size_t first, std::size_t count, MatrixXd& sum) {
      const MatrixXd q = of(first, count);
      add_outer_product(q, q, true, sum);
    }));
  }
  MatrixXf all() const {
    MatrixXf q(transform.rows(), static_cast<Index>(op.rows()));
    const std::size_t pieces = (op.rows() + rows_at_once - 1) / rows_at_once;
    tbb::parallel_for(std::size_t{0}, pieces, [&](std::size_t piece) {
      const std::size_t first = piece * rows_at_once, count = std::min(rows_at_once, op.rows() - first);
      q.middleCols(static_cast<Index>(first), static_cast<Index>(count)) = of(first, count).cast<float>();
    });
    return q;
  }
};

struct Reduction {
  MatrixXf q;
  MatrixXd factor;
};

/// Which columns depend on which is learnt from every `step`-th row; lengths and angles are then made right on all, and
/// what rounding left dependent is dropped.
Reduction reduce(const TransportOperator& op, int light, double tolerance, std::size_t step) {
  const PivotedCholesky learnt = pivoted_cholesky(operator_gram(op, light, step), tolerance);
  PivotRows rows{op, light, learnt.pivots, inverse_triangle(learnt)};
  const PivotedCholesky again = ordered_cholesky(rows.gram(), 1e-6);
  rows.transform = inverse_triangle(again) * rows.transform(again.pivots, Eigen::all);
  return {rows.all(), again.factor_transposed() * learnt.factor_transposed()};
}

/// Is the operator Q L^T, on rows that the reduction has not learnt from, as well as the tolerance promises? A column
/// that is empty on the rows learnt from counts with all that it has here.
bool represents(const TransportOperator& op, int light, const Reduction& r, std::size_t step, double tolerance) {
  const std::size_t apart = std::max(step, op.rows() / check_rows), first = step / 2,
                    count = (op.rows() - first + apart - 1) / apart;
  const MatrixXd m = columns_of(op, light, first, count, apart);
  MatrixXd q(r.q.rows(), static_cast<Index>(count));
  for (std::size_t i = 0; i < count; ++i)
    q.col(static_cast<Index>(i)) = r.q.col(static_cast<Index>(first + i * apart)).cast<double>();
  const Eigen::VectorXd left = (m - r.factor.transpose() * q).rowwise().squaredNorm(), all = m.rowwise().squaredNorm();
  constexpr double float_rounding = 1e-12;  // squared; of values and of Q
  return ((left.array() <= (10 * tolerance + float_rounding) * all.array())).all();
}

}  // namespace

MatrixXd weighted_gram(const MatrixXf& a, const MatrixXf& b, const float* weight) {
  const bool same = &a == &b && weight == nullptr;
  const auto body = [&](std::size_t first, std::size_t count, MatrixXd& sum) {
    const auto from = static_cast<Index>(first), n = static_cast<Index>(count);
    const MatrixXd left = a.middleCols(from, n).cast<double>();
    if (same) return add_outer_product(left, left, true, sum);
    MatrixXd right = b.middleCols(from, n).cast<double>();
    if (weight) right *= Eigen::Map<const Eigen::VectorXf>(weight + first, n).cast<double>().asDiagonal();
    add_outer_product(left, right, false, sum);
  };
  const MatrixXd sum = sum_over_rows(static_cast<std::size_t>(a.cols()), a.rows(), b.rows(), body);
  return same ? symmetric(sum) : sum;
}

Eigen::VectorXd basis_sum(const Eigen::MatrixXf& q, const Eigen::VectorXd& v) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(q.rows());
  constexpr Index piece = 4096;
  for (Index first = 0; first < q.cols(); first += piece) {
    const Index count = std::min(piece, q.cols() - first);
    sum += q.middleCols(first, count).cast<double>() * v.segment(first, count);
  }
  return sum;
}

OrthonormalOperator orthonormalise(const TransportOperator& op, double tolerance) {
  OrthonormalOperator out;
  const std::size_t coarse = std::max<std::size_t>(1, op.rows() / sample_rows);
  for (int light = 0; light < op.light_channels; ++light) {
    Reduction r = reduce(op, light, tolerance, coarse);
    if (coarse > 1 && !represents(op, light, r, coarse, tolerance)) {
      r = reduce(op, light, tolerance, 1);
      ++out.reduced_in_full;
    }
    out.factor.push_back(std::move(r.factor));
    out.q.push_back(std::move(r.q));
  }
  return out;
}

}  // namespace opaline
