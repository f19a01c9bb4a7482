#include "render/gl/profile_texture.h"

#include <bit>
#include <cmath>

namespace opaline::gl {
namespace {

constexpr int texels = 4096;  // profile.glsl knows it too

struct Range {
  float offset;
  std::int32_t first;  ///< bits of r^2 + offset at r = 0
  double bits_per_texel;
};

Range range_of(const ChannelProfiles& profiles, double r_max) {
  const float offset = profiles.core_radius() * profiles.core_radius() / 4;
  const std::int32_t first = std::bit_cast<std::int32_t>(offset),
                     last = std::bit_cast<std::int32_t>(static_cast<float>(r_max * r_max) + offset);
  return {offset, first, static_cast<double>(last - first) / (texels - 1)};
}

std::vector<float> sampled(const ChannelProfiles& profiles, double r_max) {
  const Range range = range_of(profiles, r_max);
  std::vector<float> row(4 * texels, 0.0f);
  for (int i = 0; i < texels; ++i) {
    const auto bits = static_cast<std::int32_t>(std::lround(range.first + range.bits_per_texel * i));
    const double r2 = static_cast<double>(std::bit_cast<float>(bits)) - static_cast<double>(range.offset);
    const double r = std::sqrt(std::max(r2, 0.0));
    row[static_cast<std::size_t>(4 * i + 3)] = profiles.inverse_scale(static_cast<float>(r));
    for (int c = 2; c >= 0; --c)
      row[static_cast<std::size_t>(4 * i + profiles.sum().table_of[c])] =
          static_cast<float>(profiles.profile(c).evaluate(r));
  }
  return row;
}

}  // namespace

ProfileTexture::ProfileTexture(const Context& context, const ChannelProfiles& profiles, double r_max)
    : texture_(context, sampled(profiles, r_max)) {
  const Range range = range_of(profiles, r_max);
  // The first and the last value stand in the middle of their texels.
  map_ = {range.offset, 1 / (range.bits_per_texel * texels)};
  first_ = range.first;
}

void ProfileTexture::bind(const Program& program, int unit) const {
  program.set("profile_map", map_);
  program.set("profile_first", first_);
  program.set("profile_texture", unit);
  texture_.bind(static_cast<unsigned>(unit));
}

}  // namespace opaline::gl
