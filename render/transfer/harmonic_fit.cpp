#include "render/transfer/harmonic_fit.h"

#include "model/check.h"
#include "render/input_error.h"
#include "render/transfer/row_sum.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

namespace opaline {
namespace {

constexpr std::size_t block = 4096;

/// Calls make(begin, end) for blocks of a row, in parallel.
template <typename Make>
void for_blocks(std::size_t stride, const Make& make) {
  tbb::parallel_for(std::size_t{0}, (stride + block - 1) / block,
                    [&](std::size_t b) { make(b * block, std::min((b + 1) * block, stride)); });
}

}  // namespace

HarmonicFit::HarmonicFit(const TransferTable& table, const TransferNodes& nodes, int order)
    : per_level_(nodes.per_level()), coefficients_(static_cast<std::size_t>(order * order)) {
  OPALINE_CHECK(!table.vectors && table.keys.size() % per_level_ == 0);
  std::vector<glm::dvec3> directions;
  for (std::size_t i = 0; i < per_level_; ++i) {
    directions.push_back(nodes.directions[i]);
    const std::vector<double> y = harmonics(order, directions.back());
    basis_.insert(basis_.end(), y.begin(), y.end());
  }
  if (!harmonic_projection(order, directions, projection_))
    throw InputError("--set directions", "",
                     fmt::format("{} directions don't determine {} coefficients; take more, or a lower order",
                                 per_level_, coefficients_));
  for (std::size_t k = 0; k < table.keys.size(); k += per_level_)
    for (std::uint32_t i = 0; i < coefficients_; ++i)
      keys_.push_back(static_cast<std::uint32_t>(table.keys[k] / per_level_ * coefficients_) + i);
}

std::vector<float> HarmonicFit::coefficients(const TransferTable& table) const {
  const auto tables = static_cast<std::size_t>(table.tables);
  std::vector<float> values(keys_.size() * tables * table.stride(), 0.0f);
  for_blocks(table.stride(), [&](std::size_t begin, std::size_t end) {
    std::vector<RowTerm> terms(per_level_);
    for (std::size_t k = 0; k < keys_.size(); ++k)
      for (std::size_t t = 0; t < tables; ++t) {
        const std::size_t first = k / coefficients_ * per_level_;
        const double* row = &projection_[k % coefficients_ * per_level_];
        for (std::size_t j = 0; j < per_level_; ++j)
          terms[j] = {table.row((first + j) * tables + t), static_cast<float>(row[j])};
        add_rows(RowStorage::f32, terms, begin, end - begin, &values[(k * tables + t) * table.stride() + begin]);
      }
  });
  return values;
}

void HarmonicFit::subtract(const std::vector<float>& coefficients, TransferTable& table) const {
  const auto tables = static_cast<std::size_t>(table.tables);
  for_blocks(table.stride(), [&](std::size_t begin, std::size_t end) {
    std::vector<RowTerm> terms(coefficients_);
    for (std::size_t k = 0; k < table.keys.size(); ++k)
      for (std::size_t t = 0; t < tables; ++t) {
        const std::size_t first = k / per_level_ * coefficients_;
        const double* y = &basis_[k % per_level_ * coefficients_];
        for (std::size_t i = 0; i < coefficients_; ++i)
          terms[i] = {&coefficients[((first + i) * tables + t) * table.stride()], static_cast<float>(-y[i])};
        add_rows(RowStorage::f32, terms, begin, end - begin, table.row(k * tables + t) + begin);
      }
  });
}

}  // namespace opaline
