#include "render/gl/profile_texture.h"

#include <cmath>

namespace opaline::gl {
namespace {

constexpr int texels = 4096;

double offset_of(const ChannelProfiles& profiles) {
  const double core = static_cast<double>(profiles.core_radius());
  return core * core / 4;
}

/// log2(r^2 + offset) at both ends.
glm::dvec2 ends(const ChannelProfiles& profiles, double r_max) {
  const double offset = offset_of(profiles);
  return {std::log2(offset), std::log2(r_max * r_max + offset)};
}

std::vector<float> sampled(const ChannelProfiles& profiles, double r_max) {
  const glm::dvec2 end = ends(profiles, r_max);
  std::vector<float> row(4 * texels, 0.0f);
  for (int i = 0; i < texels; ++i) {
    const double x = std::exp2(end.x + (end.y - end.x) * i / (texels - 1)) - offset_of(profiles);
    row[static_cast<std::size_t>(4 * i + 3)] = profiles.inverse_scale(static_cast<float>(std::sqrt(std::max(x, 0.0))));
    for (int c = 2; c >= 0; --c)
      row[static_cast<std::size_t>(4 * i + profiles.sum().table_of[c])] =
          static_cast<float>(profiles.profile(c).evaluate(std::sqrt(std::max(x, 0.0))));
  }
  return row;
}

glm::vec3 map_of(const ChannelProfiles& profiles, double r_max) {
  const glm::dvec2 end = ends(profiles, r_max);
  // The first and the last value stand in the middle of their texels.
  const double scale = (texels - 1.0) / texels / (end.y - end.x);
  return {offset_of(profiles), scale, 0.5 / texels - scale * end.x};
}

}  // namespace

ProfileTexture::ProfileTexture(const Context& context, const ChannelProfiles& profiles, double r_max)
    : map_(map_of(profiles, r_max)), texture_(context, sampled(profiles, r_max)) {}

void ProfileTexture::bind(const Program& program, int unit) const {
  program.set("profile_map", map_);
  program.set("profile_texture", unit);
  texture_.bind(static_cast<unsigned>(unit));
}

}  // namespace opaline::gl
