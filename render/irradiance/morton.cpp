#include "render/irradiance/morton.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <utility>

namespace opaline {
namespace {

constexpr int bits_an_axis = 20, digit_bits = 10, digits = 3 * bits_an_axis / digit_bits;
constexpr std::size_t buckets = std::size_t{1} << digit_bits;

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

std::size_t digit(const MortonKey& key, int d) { return (key.code >> (d * digit_bits)) & (buckets - 1); }

/// Radix sort, lowest digit first: stable, and it takes no comparisons.
void sort_by_code(std::vector<MortonKey>& keys) {
  std::vector<std::array<std::uint32_t, buckets>> count(digits);
  for (const MortonKey& key : keys)
    for (int d = 0; d < digits; ++d) ++count[static_cast<std::size_t>(d)][digit(key, d)];
  std::vector<MortonKey> other(keys.size());
  for (int d = 0; d < digits; ++d) {
    auto& place = count[static_cast<std::size_t>(d)];
    if (std::find(place.begin(), place.end(), keys.size()) != place.end()) continue;  // one value: nothing moves
    std::uint32_t sum = 0;
    for (std::uint32_t& p : place) sum += std::exchange(p, sum);
    for (const MortonKey& key : keys) other[place[digit(key, d)]++] = key;
    keys.swap(other);
  }
}

}  // namespace

std::vector<MortonKey> morton_sorted(std::span<const glm::vec3> points) {
  glm::vec3 lo(std::numeric_limits<float>::max()), hi(-lo);
  for (const glm::vec3& p : points) lo = glm::min(lo, p), hi = glm::max(hi, p);
  const glm::vec3 size = hi - lo;
  const float extent = std::max({size.x, size.y, size.z, std::numeric_limits<float>::min()});
  const float scale = static_cast<float>((1 << bits_an_axis) - 1) / extent;
  std::vector<MortonKey> keys(points.size());
  tbb::parallel_for(std::size_t{0}, (points.size() + 4095) / 4096, [&](std::size_t chunk) {
    for (std::size_t i = chunk * 4096; i < std::min(points.size(), (chunk + 1) * 4096); ++i) {
      std::uint64_t code = 0;
      for (int axis = 0; axis < 3; ++axis)
        code |= spread_bits(static_cast<std::uint64_t>((points[i][axis] - lo[axis]) * scale)) << axis;
      keys[i] = {code, static_cast<std::uint32_t>(i)};
    }
  });
  sort_by_code(keys);
  return keys;
}

std::size_t morton_split(std::span<const MortonKey> keys) {
  const std::uint64_t first = keys.front().code, last = keys.back().code;
  if (first == last) return keys.size() / 2;
  const std::uint64_t bit = std::bit_floor(first ^ last), boundary = last & ~(bit - 1);
  const auto at = std::lower_bound(keys.begin(), keys.end(), boundary,
                                   [](const MortonKey& key, std::uint64_t code) { return key.code < code; });
  return static_cast<std::size_t>(at - keys.begin());
}

void morton_pieces(std::span<const MortonKey> keys, std::size_t most, std::vector<std::size_t>& sizes) {
  if (keys.size() <= most) {
    if (!keys.empty()) sizes.push_back(keys.size());
    return;
  }
  const std::size_t middle = morton_split(keys);
  morton_pieces(keys.first(middle), most, sizes);
  morton_pieces(keys.subspan(middle), most, sizes);
}

}  // namespace opaline
