// The inner loop of a relit frame: weighted sums of rows, whatever they are stored as. Vectorised over vertices.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace opaline {

enum class RowStorage {
  f32,
  i16,   ///< value = weight * integer: the weight holds the row's scale
  i8,    ///< the same
  code8  ///< value = weight * codebook[code]
};

std::size_t bytes_of(RowStorage storage);

struct RowTerm {
  const void* row;
  float weight;
  const float* codebook = nullptr;  ///< 256 floats, of code8
};

/// out[i] += sum over terms of weight * row[i], begin <= i < end; both multiples of 16, which is what rows and `out`
/// are padded to.
void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t end, float* out);

/// out[i][0..2] += sum over the three corners k of weight_k(i) * corners[3 * triangle[i] + k][0..2], where
/// corners holds four floats a corner and weights two shorts a vertex in units of 1/weight_unit; the third weight is
/// what is left of 1. red, green, blue: the outputs.
struct CornerBlend {
  static constexpr float weight_unit = 10000;
  const float* corners;
  const std::uint32_t* triangle;
  const short* weights;  ///< pairs
};
void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t end, float* red, float* green, float* blue);

}  // namespace opaline
