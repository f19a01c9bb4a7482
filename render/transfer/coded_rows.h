// A table's rows as they are stored: floats, integers with a scale for each row, or codes of Lloyd's quantiser.
#pragma once

#include "render/transfer/lloyd.h"
#include "render/transfer/row_sum.h"
#include "render/transfer/transfer_table.h"

#include <cstddef>
#include <vector>

namespace opaline {

class CodedRows {
 public:
  /// Vertices that are skipped or worked through together.
  static constexpr std::size_t block = 1024;

  CodedRows() = default;
  /// rows * stride floats; books: how many rows in a row (row % books) have a codebook of their own.
  CodedRows(RowStorage storage, std::vector<float> values, std::size_t rows, std::size_t vertices, int books);

  RowStorage storage() const { return storage_; }
  std::size_t rows() const { return rows_; }
  std::size_t vertices() const { return vertices_; }
  std::size_t stride() const { return stride_; }
  std::size_t blocks() const { return (stride_ + block - 1) / block; }
  const std::byte* bytes(std::size_t row) const { return data_.data() + row * stride_ * bytes_of(storage_); }
  const std::vector<std::byte>& data() const { return data_; }
  const std::vector<Codebook>& codebooks() const { return codebooks_; }
  float scale(std::size_t row) const { return scale_.empty() ? 1 : scale_[row]; }

  /// One row times a weight.
  RowTerm term(std::size_t row, float weight) const;
  /// Is some value of the row in that block above 0, in size? (Values below 1e-7 of the largest of all don't count.)
  bool lit(std::size_t row, std::size_t b) const { return lit_[row * blocks() + b]; }
  /// What is stored for each vertex, without the padding.
  double bytes_per_vertex() const;

 private:
  void quantise(const std::vector<float>& values, double largest);
  void make_codes(const std::vector<float>& values, int books);
  void find_lit(const std::vector<float>& values);

  RowStorage storage_ = RowStorage::f32;
  std::size_t rows_ = 0, vertices_ = 0, stride_ = 0;
  std::vector<std::byte> data_;
  std::vector<float> scale_;
  std::vector<Codebook> codebooks_;
  std::vector<bool> lit_;
};

}  // namespace opaline
