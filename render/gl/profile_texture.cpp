#include "render/gl/profile_texture.h"

#include <algorithm>
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

float narrowest_squared(const ChannelProfiles& profiles) {
  double core = profiles.profile(0).core_radius();
  for (int c = 1; c < 3; ++c) core = std::min(core, profiles.profile(c).core_radius());
  return static_cast<float>(core * core);
}

/// -d ln R / dr by a central difference in ln R.
double log_slope(const Profile& profile, double r) {
  const double h = 1e-4 * r, below = profile.evaluate(r - h), above = profile.evaluate(r + h);
  return above > 0 && below > 0 ? std::log(below / above) / (2 * h) : 0;
}

/// 1 / (the length over which the steepest profile changes) at r.
double inverse_scale(const ChannelProfiles& profiles, double r) {
  double steepest = 0;
  for (int c = 0; c < 3; ++c) {
    const Profile& profile = profiles.profile(c);
    const double slope = r > 0 ? log_slope(profile, r) : 0, z = profile.core_radius();
    steepest = std::max(steepest, std::sqrt(slope * slope + 1 / (r * r + z * z)));
  }
  return steepest;
}

Range range_of(const ChannelProfiles& profiles, double r_max) {
  const float offset = narrowest_squared(profiles) / 4;
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
    row[static_cast<std::size_t>(4 * i + 3)] = static_cast<float>(inverse_scale(profiles, r));
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
  core_squared_ = narrowest_squared(profiles);
}

void ProfileTexture::bind(const Program& program, int unit) const {
  program.set("profile_map", map_);
  program.set("profile_first", first_);
  program.set("profile_texture", unit);
  texture_.bind(static_cast<unsigned>(unit));
}

}  // namespace opaline::gl
