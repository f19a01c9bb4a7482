// A radial profile sampled once in double and evaluated in float at millions of radii: piecewise
// cubics in x = r^2 + x0, eight segments an octave, addressed by the bits of x. No root, no
// exponential, no division.
#pragma once

#include <bit>
#include <cstdint>
#include <functional>
#include <vector>

namespace opaline {

class ProfileTable {
 public:
  static constexpr int segment_shift = 20;  ///< 3 mantissa bits choose the segment within an octave

  /// The bare table, for loops the compiler vectorises: copy it into a local first.
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

  ProfileTable() = default;
  /// profile      R(r), r [mm], smooth in r^2 on the scale core_radius^2
  /// core_radius  > 0 [mm]; r_max > 0 [mm]; a radius beyond it gets some value of the last segment,
  ///              whose radii are within 6.1 % of r_max
  /// Error, for the measured materials out to 100 core radii (tests/model): 5e-7 of R(0), and 1e-6 of the
  /// profile's integral over the plane; relative to R(r) 5e-6 where R falls no faster than r^-3.5, 1e-5
  /// down to r^-5, 1e-4 down to r^-10, 2e-3 down to r^-20: it grows with the fourth power and more.
  ProfileTable(const std::function<double(double)>& profile, double core_radius, double r_max);

  float operator()(float r2) const { return view()(r2); }
  View view() const { return {coefficients_.data(), offset_, first_segment_, last_segment_}; }
  double r_max() const { return r_max_; }
  std::size_t bytes() const { return coefficients_.size() * sizeof(float); }

 private:
  float offset_ = 1;
  std::int32_t first_segment_ = 0, last_segment_ = 0;
  std::vector<float> coefficients_;
  double r_max_ = 0;
};

}  // namespace opaline
