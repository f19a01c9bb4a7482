// The inner loop of a relit frame: weighted sums of rows, whatever they are stored as. Vectorised over vertices.
#pragma once

#include <array>
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

/// out[i] += sum over terms of weight * row[begin + i], i < count; begin and count multiples of 16, which is what rows
/// are padded to. next: the terms of the next call, which are fetched into the cache meanwhile; or none.
void add_rows(RowStorage storage, std::span<const RowTerm> terms, std::size_t begin, std::size_t count, float* out,
              std::span<const RowTerm> next = {});

/// What three of the reference points give a vertex: sum over the corners k of weight_k * points[4 * corner_k +
/// colour], where points holds four floats a point and weights two shorts a vertex in units of 1 / weight_unit; the
/// third weight is what is left of 1.
struct CornerBlend {
  static constexpr float weight_unit = 10000;
  const float* points;
  const std::uint32_t* triangles;  ///< three points each
  const std::uint32_t* triangle_of;
  const short* weights;  ///< pairs
  float correction;      ///< the most that the blend is corrected by, in shares of itself
};
/// colour[c][i], the correction of vertex begin + i, gets bounded and the blend added, i < count; both multiples of 16.
void add_blend(const CornerBlend& blend, std::size_t begin, std::size_t count, const std::array<float*, 3>& colour);

/// out[i] = factor * sum[i], or 0 where that is negative; returns how often it is.
std::size_t store_exitance(const float* sum, float factor, std::size_t count, float* out);

}  // namespace opaline
