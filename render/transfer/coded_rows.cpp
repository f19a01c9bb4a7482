#include "render/transfer/coded_rows.h"

#include "model/check.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace opaline {
namespace {

/// Calls make(i) for every value, in parallel.
template <typename Make>
void for_rows(std::size_t rows, std::size_t stride, const Make& make) {
  tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t r) {
    for (std::size_t i = r * stride; i < (r + 1) * stride; ++i) make(r, i);
  });
}

}  // namespace

CodedRows::CodedRows(RowStorage storage, std::vector<float> values, std::size_t rows, std::size_t vertices, int books)
    : storage_(storage),
      rows_(rows),
      vertices_(vertices),
      stride_((vertices + TransferTable::lanes - 1) / TransferTable::lanes * TransferTable::lanes) {
  OPALINE_CHECK(values.size() == rows_ * stride_);
  find_lit(values);
  data_.resize(values.size() * bytes_of(storage));
  if (storage == RowStorage::f32) std::memcpy(data_.data(), values.data(), data_.size());
  if (storage == RowStorage::i16) quantise(values, 32767);
  if (storage == RowStorage::i8) quantise(values, 127);
  if (storage == RowStorage::code8) make_codes(values, books);
}

void CodedRows::quantise(const std::vector<float>& values, double largest) {
  scale_.assign(rows_, 0.0f);
  for_rows(rows_, stride_, [&](std::size_t r, std::size_t i) { scale_[r] = std::max(scale_[r], std::abs(values[i])); });
  for (float& s : scale_) s = static_cast<float>(static_cast<double>(s) / largest);
  const auto number = [&](std::size_t r, std::size_t i) {
    return scale_[r] > 0 ? std::clamp(std::round(static_cast<double>(values[i] / scale_[r])), -largest, largest) : 0.0;
  };
  if (storage_ == RowStorage::i16) {
    auto* out = reinterpret_cast<std::int16_t*>(data_.data());
    for_rows(rows_, stride_, [&](std::size_t r, std::size_t i) { out[i] = static_cast<std::int16_t>(number(r, i)); });
  } else {
    auto* out = reinterpret_cast<std::int8_t*>(data_.data());
    for_rows(rows_, stride_, [&](std::size_t r, std::size_t i) { out[i] = static_cast<std::int8_t>(number(r, i)); });
  }
}

void CodedRows::make_codes(const std::vector<float>& values, int books) {
  constexpr std::size_t most = 1 << 20;  // values that a codebook is made from
  const auto count = static_cast<std::size_t>(books);
  codebooks_.resize(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t b) {
    const std::size_t all = (rows_ + count - 1 - b) / count * vertices_, step = all / most + 1;
    std::vector<float> sample;
    for (std::size_t r = b, k = 0; r < rows_; r += count)
      for (std::size_t v = 0; v < vertices_; ++v, ++k)
        if (k % step == 0) sample.push_back(values[r * stride_ + v]);
    codebooks_[b] = lloyd_codebook(sample);
  });
  auto* out = reinterpret_cast<std::uint8_t*>(data_.data());
  for_rows(rows_, stride_, [&](std::size_t r, std::size_t i) { out[i] = encode(codebooks_[r % count], values[i]); });
}

void CodedRows::find_lit(const std::vector<float>& values) {
  float largest = 0;
  for (const float v : values) largest = std::max(largest, std::abs(v));
  lit_.assign(rows_ * blocks(), false);
  for (std::size_t r = 0; r < rows_; ++r)
    for (std::size_t i = 0; i < stride_; ++i)
      if (std::abs(values[r * stride_ + i]) > 1e-7f * largest) lit_[r * blocks() + i / block] = true;
}

RowTerm CodedRows::term(std::size_t row, float weight) const {
  return {bytes(row), weight * scale(row), codebooks_.empty() ? nullptr : codebooks_[row % codebooks_.size()].data()};
}

double CodedRows::bytes_per_vertex() const { return static_cast<double>(rows_ * bytes_of(storage_)); }

}  // namespace opaline
