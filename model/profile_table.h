// A radial profile sampled once in double and evaluated in float at millions of radii, as polynomials in
// x = r^2 + x0 addressed by the bits of x: no root, no exponential, no division. Two forms of the same profile:
//
//   rows       cubics, 16 segments an octave, a row of four coefficients each: for any range and any processor
//   registers  at most 32 segments, a column of 32 numbers per coefficient: what AVX-512 looks up by permuting two
//              registers. Degree 6 with 2 segments an octave reaches 210 core radii, degree 8 with one 54000.
//
// profile_table_kernel.h evaluates vectors; this header evaluates one radius, from the rows.
//
// Error. Segments are interpolated at Gauss-Legendre nodes, so what is left over integrates to almost nothing over
// a segment: errors of a sum over a surface are far below those of its terms. For standard dipoles of every material
// of the library out to 100 core radii (tests/model), sums over disks, lines, bodies and rings: 1e-5
// (registers), 2e-6 (rows). Terms:
//              of R(0)   of R(r) where it falls no faster than r^-3.5     r^-5     r^-10    r^-20
//   rows          2e-7                                           1e-6     2e-6      2e-5     2e-4
//   registers     4e-6                                           1e-5     2e-5      2e-4     1e-2
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

namespace opaline {

class ProfileTable {
 public:
  static constexpr int segment_shift = 19;  ///< of the rows: 4 mantissa bits choose the segment within an octave

  /// The rows, for loops the compiler vectorises: copy it into a local first.
  struct View {
    const float* coefficients;
    float offset;
    std::int32_t first_segment, last_segment;

    /// R at squared distance r2 [mm^2] >= 0.
    [[gnu::always_inline]] float operator()(float r2) const {
      const std::int32_t bits = std::bit_cast<std::int32_t>(r2 + offset);
      std::int32_t segment = (bits >> segment_shift) - first_segment;
      segment = segment > last_segment ? last_segment : segment;
      const float f = static_cast<float>(bits & ((1 << segment_shift) - 1)) * (1.0f / (1 << segment_shift));
      const std::int32_t c = 4 * segment;  // indexed from the table's start: compilers then emit gathers
      return ((coefficients[c + 3] * f + coefficients[c + 2]) * f + coefficients[c + 1]) * f + coefficients[c];
    }
  };

  /// The columns: coefficient k of segment s is columns[32 k + s], in powers of t = (place in the segment - 1/2) times
  /// the segment's share of an octave, 1/2 or 1.
  struct Registers {
    static constexpr std::size_t entries = 32;
    const float* columns;  ///< aligned to 64 bytes
    float offset, x_max;   ///< x beyond x_max counts as x_max
    std::int32_t first_segment;
    int per_octave;  ///< segments an octave: 2, 1, or 0 if the range does not fit: then only the rows can be used

    static constexpr int shift(int per_octave) { return per_octave == 2 ? 22 : 23; }
    static constexpr int degree(int per_octave) { return per_octave == 2 ? 6 : 8; }
  };

  ProfileTable() = default;
  /// profile      R(r), r [mm], smooth in r^2 on the scale core_radius^2
  /// core_radius  > 0 [mm]; r_max > 0 [mm]; a radius beyond it gets some value of the last segment,
  ///              whose radii are within 3.1 % (rows) or 23 % (registers; 42 % beyond 210 core radii) of r_max
  /// Tables of the same core_radius and r_max have the same segments: a kernel finds the segment once for all.
  ProfileTable(const std::function<double(double)>& profile, double core_radius, double r_max);

  float operator()(float r2) const { return view()(r2); }
  View view() const { return {rows_.data(), offset_, first_segment_, last_segment_}; }
  Registers registers() const {
    return {columns_.data()->number, register_offset_, register_x_max_, first_register_, per_octave_};
  }
  bool same_segments(const ProfileTable& other) const {
    return core_radius_ == other.core_radius_ && r_max_ == other.r_max_;
  }
  double r_max() const { return r_max_; }
  std::size_t bytes() const { return rows_.size() * sizeof(float) + columns_.size() * sizeof(Line); }

 private:
  struct alignas(64) Line {
    float number[16];
  };
  void fill_rows(const std::function<double(double)>& profile);
  template <int PerOctave>
  bool fill_columns(const std::function<double(double)>& profile);

  double core_radius_ = 0, r_max_ = 0;
  float offset_ = 1;
  std::int32_t first_segment_ = 0, last_segment_ = 0;
  std::vector<float> rows_;
  float register_offset_ = 1, register_x_max_ = 1;
  std::int32_t first_register_ = 0;
  int per_octave_ = 0;
  std::vector<Line> columns_;
};

}  // namespace opaline
