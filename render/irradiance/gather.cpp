#include "render/irradiance/gather.h"

#include <limits>

namespace opaline {
namespace {

/// Spreads the lower 21 bits of x so that two zero bits follow each.
std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

}  // namespace

std::vector<std::uint32_t> morton_order(std::span<const glm::vec3> points) {
  glm::vec3 lo(std::numeric_limits<float>::max()), hi(-lo);
  for (const glm::vec3& p : points) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const glm::vec3 size = hi - lo;
  const float extent = std::max({size.x, size.y, size.z, std::numeric_limits<float>::min()});
  std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
  keyed.reserve(points.size());
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    std::uint64_t code = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double unit = static_cast<double>((points[i][axis] - lo[axis]) / extent);
      code |= spread_bits(static_cast<std::uint64_t>(unit * 0x1fffff)) << axis;
    }
    keyed.emplace_back(code, i);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::uint32_t> order;
  order.reserve(points.size());
  for (const auto& [code, i] : keyed) order.push_back(i);
  return order;
}

}  // namespace opaline
