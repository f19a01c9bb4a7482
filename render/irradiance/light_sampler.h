// Directions from which a point is lit, light by light. No visibility, no surface: just where the
// light comes from and how much arrives on a plane facing it.
#pragma once

#include "render/scene/scene.h"

#include <array>
#include <functional>
#include <vector>

namespace opaline {

struct LightSample {
  glm::vec3 direction;   ///< unit, towards the light
  float distance;        ///< mm; infinite for directional and environment lights
  glm::vec3 irradiance;  ///< on a plane facing the light, this sample's share
};

class LightSampler {
 public:
  /// area_samples: directions an extended light (disk, environment) gets at one point.
  LightSampler(const Scene& scene, int area_samples);

  /// Calls visit(LightSample) for each direction. `index` and `seed` number the point: extended
  /// lights draw directions from a low-discrepancy sequence of `index`, shifted at random by `seed`.
  template <typename Visit>
  void for_each(const glm::vec3& point, std::uint64_t seed, std::uint32_t index, Visit&& visit) const {
    for (std::size_t i = 0; i < lights_.size(); ++i) {
      const int n = extended_[i] ? area_samples_ : 1;
      for (int k = 0; k < n; ++k) {
        const LightSample sample =
            draw(i, point, seed, index * static_cast<std::uint32_t>(n) + static_cast<std::uint32_t>(k), n);
        if (sample.irradiance != glm::vec3(0)) visit(sample);
      }
    }
  }
  /// One direction of one light, by a random number.
  LightSample sample(std::size_t light, const glm::vec3& point, std::uint64_t random) const {
    return draw(light, point, random, 0, 1);
  }
  /// If every light has the same colour up to a factor: that colour, its largest channel 1. The
  /// three channels of the irradiance are then one field times this colour.
  bool single_colour(Rgb& colour) const;

 private:
  LightSample draw(std::size_t light, const glm::vec3& point, std::uint64_t seed, std::uint32_t number, int n) const;
  LightSample draw_environment(std::size_t light, float u, float v, int n) const;

  struct EnvironmentTable {
    std::vector<double> rows, columns;  ///< cumulative: marginal over rows, conditional per row
  };
  const std::vector<Light>& lights_;
  std::vector<bool> extended_;
  std::vector<EnvironmentTable> tables_;  ///< per light; empty but for environments
  int area_samples_;
};

/// Radiance of a lat-long environment in direction w (towards the environment), bilinear.
Rgb environment_radiance(const EnvironmentLight& light, const glm::dvec3& w);

/// Uniform numbers in [0,1)^2: point `number` of the R2 sequence, shifted at random by `seed`.
std::array<float, 2> shifted_r2(std::uint64_t seed, std::uint32_t number);

}  // namespace opaline
