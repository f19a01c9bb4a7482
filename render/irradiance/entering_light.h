// The light that enters a surface at one point: the sum over lights of V cos F_t(eta, cos) L.
#pragma once

#include "model/fresnel.h"
#include "render/irradiance/light_sampler.h"
#include "render/visibility/ray_scene.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace opaline {

/// For several refraction indices at once. Counts the shadow rays it casts; one per thread.
struct EnteringLight {
  const RayScene& rays;
  const LightSampler& lights;
  const std::vector<double>& etas;
  int channels;                                     ///< 3, or 1: the largest channel of the irradiance
  bool unshadowed = false;                          ///< nothing casts a shadow: no rays
  std::uint64_t done = 0, skipped = 0, spared = 0;  ///< shadow rays: cast; facing away; not needed

  /// Adds weight times the irradiance that enters at a point to out[eta * channels + channel].
  void add(const SurfacePoint& p, std::uint64_t seed, std::uint32_t index, double weight, double* out) {
    lights.for_each(p.position, seed, index, [&](const LightSample& sample) {
      const float cosine = glm::dot(p.normal, sample.direction);
      if (cosine <= 0 || glm::dot(p.face_normal, sample.direction) <= 0) {
        ++skipped;
        return;
      }
      ++(unshadowed ? spared : done);
      if (!unshadowed && rays.occluded(p.position + rays.offset() * p.face_normal, sample.direction, sample.distance))
        return;
      const double c = std::min(static_cast<double>(cosine), 1.0);
      for (std::size_t k = 0; k < etas.size(); ++k) {
        const double entering = weight * c * fresnel_transmittance(c, etas[k]);
        for (int ch = 0; ch < channels; ++ch)
          out[k * static_cast<std::size_t>(channels) + static_cast<std::size_t>(ch)] +=
              entering * static_cast<double>(
                             channels == 1 ? std::max({sample.irradiance.r, sample.irradiance.g, sample.irradiance.b})
                                           : sample.irradiance[ch]);
      }
    });
  }
};

}  // namespace opaline
