#include "fit/block_product.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "fit/block_product.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

#ifndef OPALINE_BLOCK_PRODUCT_ONCE
#define OPALINE_BLOCK_PRODUCT_ONCE
namespace opaline {

/// sum += a b, where a and sum have their columns `a_step` and `sum_step` apart and b has its elements where it likes.
struct BlockProduct {
  const double *a, *b;
  double* sum;
  std::size_t rows, columns, depth;
  std::size_t a_step, b_down, b_across, sum_step;
  bool lower;
};

}  // namespace opaline
#endif

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using ProductD = hn::CappedTag<double, 8>;
using ProductV = hn::Vec<ProductD>;

/// A tile of the sum is two vectors high and so many columns wide: what twelve registers hold.
constexpr std::size_t tile_columns = 6, tile_rows = 2 * hn::MaxLanes(ProductD());
/// So many columns of a, a tile high, stay in the first cache while b passes by.
constexpr std::size_t panel_depth = 192;

/// Columns first_depth .. of a tile's rows of a, one behind the other, zeros where a has no rows; returns how many are
/// left when those that are zero at the end are left out.
HWY_INLINE std::size_t fill_panel(const BlockProduct& p, std::size_t first_row, std::size_t first_depth,
                                  double* panel) {
  const std::size_t count = std::min(tile_rows, p.rows - first_row);
  std::size_t depth = std::min(panel_depth, p.depth - first_depth);
  for (std::size_t l = 0; l < depth; ++l) {
    const double* from = p.a + (first_depth + l) * p.a_step + first_row;
    std::fill(std::copy_n(from, count, panel + l * tile_rows), panel + (l + 1) * tile_rows, 0.0);
  }
  const auto zero = [](double x) { return x == 0; };
  while (depth > 0 && std::all_of(panel + (depth - 1) * tile_rows, panel + depth * tile_rows, zero)) --depth;
  return depth;
}

/// Columns first .. of b, as offsets; the last again where b has no more.
HWY_INLINE void add_tile(const BlockProduct& p, const double* panel, std::size_t depth, const double* b,
                         std::size_t first, double* tile) {
  const ProductD d;
  const std::size_t lanes = hn::Lanes(d);
  std::size_t at[tile_columns];
  for (std::size_t j = 0; j < tile_columns; ++j) at[j] = std::min(first + j, p.columns - 1) * p.b_across;
  ProductV sum[tile_columns][2];
  for (auto& s : sum) s[0] = s[1] = hn::Zero(d);
  for (std::size_t l = 0; l < depth; ++l) {
    const ProductV upper = hn::Load(d, panel + l * tile_rows), lower = hn::Load(d, panel + l * tile_rows + lanes);
    for (std::size_t j = 0; j < tile_columns; ++j) {
      const ProductV x = hn::Set(d, b[l * p.b_down + at[j]]);
      sum[j][0] = hn::MulAdd(upper, x, sum[j][0]);
      sum[j][1] = hn::MulAdd(lower, x, sum[j][1]);
    }
  }
  for (std::size_t j = 0; j < tile_columns; ++j) {
    hn::Store(sum[j][0], d, tile + j * tile_rows);
    hn::Store(sum[j][1], d, tile + j * tile_rows + lanes);
  }
}

void add_block_product(const BlockProduct& p) {
  HWY_ALIGN double panel[panel_depth * tile_rows], tile[tile_columns * tile_rows];
  for (std::size_t i = 0; i < p.rows; i += tile_rows)
    for (std::size_t l = 0; l < p.depth; l += panel_depth) {
      const std::size_t depth = fill_panel(p, i, l, panel), end = std::min(p.rows, i + tile_rows);
      if (depth == 0) continue;
      const std::size_t columns = p.lower ? std::min(p.columns, end) : p.columns;
      for (std::size_t j = 0; j < columns; j += tile_columns) {
        add_tile(p, panel, depth, p.b + l * p.b_down, j, tile);
        for (std::size_t c = j; c < std::min(j + tile_columns, p.columns); ++c)
          for (std::size_t r = i; r < end; ++r) p.sum[c * p.sum_step + r] += tile[(c - j) * tile_rows + r - i];
      }
    }
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {
namespace {

HWY_EXPORT(add_block_product);

void add(const Eigen::MatrixXd& a, const double* b, Eigen::Index b_down, Eigen::Index b_across, bool lower,
         Eigen::MatrixXd& sum) {
  const auto size = [](Eigen::Index n) { return static_cast<std::size_t>(n); };
  HWY_DYNAMIC_DISPATCH(add_block_product)
  ({a.data(), b, sum.data(), size(sum.rows()), size(sum.cols()), size(a.cols()), size(a.rows()), size(b_down),
    size(b_across), size(sum.rows()), lower});
}

}  // namespace

void add_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, Eigen::MatrixXd& sum) {
  add(a, b.data(), 1, b.rows(), false, sum);
}

void add_outer_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, bool lower, Eigen::MatrixXd& sum) {
  add(a, b.data(), b.rows(), 1, lower, sum);
}

}  // namespace opaline
#endif
