#include "render/gl/profile_family.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace opaline::gl {
namespace {

constexpr int radii = 4096;  // profile_family.glsl knows it too
constexpr int media = 256;
constexpr double u_min = 1e-4;  // a reduced albedo of 1 - 1e-8 counts as 1

double u_of(double sigma_a, double sigma_s_prime) {
  return std::max(std::sqrt(sigma_a / (sigma_a + sigma_s_prime)), u_min);
}

/// Smallest and largest value over an image, per channel.
struct Extent {
  Rgb least, most;
};

Extent extent(const std::shared_ptr<const MaterialMap>& map, const Rgb& constant) {
  return map ? Extent{map->smallest(), map->largest()} : Extent{constant, constant};
}

}  // namespace

ProfileFamily::ProfileFamily(const Context& context, const ProfileInfo& info, const Material& material, double r_max) {
  const Extent a = extent(material.sigma_a_map, material.sigma_a),
               s = extent(material.sigma_s_prime_map, material.sigma_s_prime);
  double u_low = 1, u_high = u_min, s_max = 0;
  for (int c = 0; c < 3; ++c) {
    u_low = std::min(u_low, u_of(a.least[c], s.most[c])), u_high = std::max(u_high, u_of(a.most[c], s.least[c]));
    s_max = std::max(s_max, a.most[c] + s.most[c]);
  }
  log_u_min_ = std::log(u_low), log_u_max_ = std::max(std::log(u_high), log_u_min_ + 1e-3);
  std::vector<std::unique_ptr<Profile>> profiles;
  double core = 1e300;
  for (int k = 0; k < media; ++k) {
    const double u = std::min(std::exp(log_u_min_ + (log_u_max_ - log_u_min_) * k / (media - 1)), 1.0);
    profiles.push_back(info.make({u * u, (1 - u) * (1 + u), material.eta}));
    core = std::min(core, profiles.back()->core_radius());
  }
  const float offset = static_cast<float>(core * core / 4), x_max = static_cast<float>(s_max * r_max);
  first_ = std::bit_cast<std::int32_t>(offset);
  const double bits_per_texel =
      static_cast<double>(std::bit_cast<std::int32_t>(x_max * x_max + offset) - first_) / (radii - 1);
  map_ = {offset, 1 / (bits_per_texel * radii)};
  std::vector<float> texels;
  texels.reserve(static_cast<std::size_t>(radii) * media);
  for (const auto& profile : profiles)
    for (int i = 0; i < radii; ++i) {
      const auto bits = static_cast<std::int32_t>(std::lround(first_ + bits_per_texel * i));
      const double x2 = static_cast<double>(std::bit_cast<float>(bits)) - static_cast<double>(offset);
      texels.push_back(static_cast<float>(profile->evaluate(std::sqrt(std::max(x2, 0.0)))));
    }
  texture_ = std::make_unique<Texture2D>(context, radii, media, Format::r32f, texels.data(), Sampling::linear);
}

void ProfileFamily::bind(const Program& program, int unit) const {
  program.set("family_map", map_);
  program.set("family_first", first_);
  program.set("profile_family", unit);
  texture_->bind(static_cast<unsigned>(unit));
}

glm::vec2 ProfileFamily::place(const Medium<double>& medium) const {
  const double log_u = std::log(u_of(medium.sigma_a, medium.sigma_s_prime));
  const double row = (media - 1) * std::clamp((log_u - log_u_min_) / (log_u_max_ - log_u_min_), 0.0, 1.0);
  return {medium.sigma_a + medium.sigma_s_prime, (row + 0.5) / media};
}

}  // namespace opaline::gl
