#include "model/profile_table.h"

#include "model/check.h"
#include "model/conventions.h"

#include <array>
#include <cmath>

namespace opaline {
namespace {

/// Monomial coefficients on [0, 1] of the cubic through the four Chebyshev nodes of the segment.
std::array<float, 4> fit_cubic(const std::function<double(double)>& value_at) {
  std::array<double, 4> node, difference;
  for (int i = 0; i < 4; ++i) {
    node[i] = 0.5 + 0.5 * std::cos((2 * i + 1) * pi / 8);
    difference[i] = value_at(node[i]);
  }
  for (int level = 1; level < 4; ++level)
    for (int i = 3; i >= level; --i) difference[i] = (difference[i] - difference[i - 1]) / (node[i] - node[i - level]);
  std::array<double, 4> c{difference[3], 0, 0, 0};  // Newton form expanded, highest divided difference first
  for (int level = 2; level >= 0; --level) {
    for (int k = 3; k > 0; --k) c[k] = c[k - 1] - node[level] * c[k];
    c[0] = difference[level] - node[level] * c[0];
  }
  return {static_cast<float>(c[0]), static_cast<float>(c[1]), static_cast<float>(c[2]), static_cast<float>(c[3])};
}

}  // namespace

ProfileTable::ProfileTable(const std::function<double(double)>& profile, double core_radius, double r_max)
    : r_max_(r_max) {
  OPALINE_CHECK(core_radius > 0 && r_max > 0);
  // x0 sits on a segment boundary, so that the first segment starts at r = 0 exactly.
  first_segment_ = std::bit_cast<std::int32_t>(static_cast<float>(core_radius * core_radius / 4)) >> segment_shift;
  offset_ = std::bit_cast<float>(first_segment_ << segment_shift);
  const float x_max = static_cast<float>(r_max * r_max) + offset_;
  last_segment_ = (std::bit_cast<std::int32_t>(x_max) >> segment_shift) - first_segment_;
  coefficients_.reserve(4 * (static_cast<std::size_t>(last_segment_) + 1));
  for (std::int32_t s = 0; s <= last_segment_; ++s) {
    const double lo = std::bit_cast<float>((first_segment_ + s) << segment_shift);
    const double hi = std::bit_cast<float>((first_segment_ + s + 1) << segment_shift);
    const auto cubic = fit_cubic([&](double f) {
      const double r2 = lo + f * (hi - lo) - static_cast<double>(offset_);
      return profile(std::sqrt(std::fmax(r2, 0.0)));
    });
    coefficients_.insert(coefficients_.end(), cubic.begin(), cubic.end());
  }
}

}  // namespace opaline
