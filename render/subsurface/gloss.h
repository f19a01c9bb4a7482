// Light that the surface itself reflects, before any of it enters: an optional part of subsurface texture mapping.
//
// Microfacets of Trowbridge & Reitz (GGX), alpha = roughness^2, height-correlated Smith shadowing, and Schlick's
// approximation of the Fresnel term from the refraction index. Nothing is traced: no shadows. The shader's twin is in
// render/techniques/subsurface_texture.frag.
#pragma once

#include "render/subsurface/march.h"

namespace opaline {

/// Reflectance at normal incidence.
inline float reflectance_at_normal(double eta) {
  return static_cast<float>((eta - 1) * (eta - 1) / ((eta + 1) * (eta + 1)));
}

/// Radiance towards w_o of one light, at a point with that normal. roughness in (0, 1].
inline glm::vec3 gloss(const FramedPoint& p, const MarchLight& light, float f0, float roughness) {
  const glm::vec3 w_i = light.towards(p.position), sum = w_i + p.w_o;
  const float cos_i = glm::dot(p.normal, w_i), cos_o = glm::dot(p.normal, p.w_o);
  if (!(cos_i > 0) || !(cos_o > 0) || !(glm::dot(sum, sum) > 0)) return glm::vec3(0);
  const glm::vec3 h = glm::normalize(sum);
  const float a2 = roughness * roughness * roughness * roughness, cos_h = glm::dot(p.normal, h);
  const float d = cos_h * cos_h * (a2 - 1) + 1, density = a2 / (static_cast<float>(pi) * d * d);
  const float visible =
      0.5f / (cos_o * std::sqrt(a2 + (1 - a2) * cos_i * cos_i) + cos_i * std::sqrt(a2 + (1 - a2) * cos_o * cos_o));
  const float turned = 1 - std::max(glm::dot(w_i, h), 0.0f), turned2 = turned * turned;
  const float fresnel = f0 + (1 - f0) * turned2 * turned2 * turned;
  return light.irradiance(p.position) * (cos_i * fresnel * density * visible);
}

}  // namespace opaline
