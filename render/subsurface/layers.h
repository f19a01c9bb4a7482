// Layers along straight ways: in what layer each part of a way lies, and light on it.
//
// Along a way the depth below the surface and the depths of the boundaries are taken to change evenly between its ends,
// so boundaries are crossed where that says: the error is of second order in the length of a way.
#pragma once

#include "render/scene/layered_medium.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {

/// The layers of a medium in float, for inner loops. Index `count` is what lies below the last layer.
struct MediumLayers {
  int count = 0;
  std::array<glm::vec3, LayeredMedium::most_layers + 1> sigma_s{}, sigma_t{};
  std::array<float, LayeredMedium::most_layers + 1> g{};
  std::array<bool, LayeredMedium::most_layers + 1> schlick{};

  MediumLayers() = default;
  explicit MediumLayers(const LayeredMedium& medium) : MediumLayers(medium.layers, medium.layers.back()) {}
  /// 1 .. most_layers layers; light fades below them as in `beneath`.
  MediumLayers(const std::vector<SubsurfaceLayer>& layers, const SubsurfaceLayer& beneath)
      : count(static_cast<int>(layers.size())) {
    for (std::size_t k = 0; k < layers.size(); ++k) {
      const SubsurfaceLayer& layer = layers[k];
      sigma_s[k] = glm::vec3(layer.sigma_s), sigma_t[k] = glm::vec3(layer.sigma_t);
      g[k] = std::clamp(static_cast<float>(layer.g), -0.9999f, 0.9999f);
      schlick[k] = layer.phase == Phase::schlick;
    }
    sigma_t[layers.size()] = glm::vec3(beneath.sigma_t);
  }

  /// Phase function [1/sr] of light that travels against w_i (towards the light) and goes on along w_o.
  float phase(int layer, const glm::vec3& w_i, const glm::vec3& w_o) const {
    const auto k = static_cast<std::size_t>(layer);
    const double cosine = std::clamp(-static_cast<double>(glm::dot(w_i, w_o)), -1.0, 1.0),
                 parameter = static_cast<double>(g[k]);
    return static_cast<float>(schlick[k] ? schlick_phase(cosine, parameter) : henyey_greenstein(cosine, parameter));
  }
};

/// A place inside: how far it is below each boundary [mm], negative above it.
struct LayerPlace {
  std::array<float, LayeredMedium::most_layers> below{};

  /// At a depth, with the depths at which the layers end.
  LayerPlace() = default;
  LayerPlace(float depth, const float* boundaries, int count) {
    for (int k = 0; k < count; ++k) below[static_cast<std::size_t>(k)] = depth - boundaries[k];
  }
};

/// The layer a place is in: the first whose end is deeper.
inline int layer_at(const LayerPlace& place, int count) {
  int layer = 0;
  while (layer < count && place.below[static_cast<std::size_t>(layer)] >= 0) ++layer;
  return layer;
}

/// Calls piece(layer, t0, t1) for the parts of the way from a (t = 0) to b (t = 1), in order. Boundaries don't cross
/// each other, so the layers between are met one after the other.
template <typename Piece>
void for_each_piece(const LayerPlace& a, const LayerPlace& b, int count, Piece&& piece) {
  int layer = layer_at(a, count);
  const int last = layer_at(b, count), direction = last > layer ? 1 : -1;
  float t = 0;
  for (; layer != last; layer += direction) {
    const auto k = static_cast<std::size_t>(direction > 0 ? layer : layer - 1);
    const float cut = std::clamp(a.below[k] / (a.below[k] - b.below[k]), t, 1.0f);
    if (cut > t) piece(layer, t, cut);
    t = cut;
  }
  if (t < 1) piece(layer, t, 1.0f);
}

/// Mean of e^-x for x from 0 to delta in each channel: what light that fades along a way is worth. Any sign of delta.
inline float mean_transmittance(float delta) {
  if (std::abs(delta) > 0.02f) return -std::expm1(-delta) / delta;
  return 1 - delta * (0.5f - delta * (1.0f / 6 - delta / 24));
}
inline glm::vec3 mean_transmittance(const glm::vec3& delta) {
  return {mean_transmittance(delta.x), mean_transmittance(delta.y), mean_transmittance(delta.z)};
}

}  // namespace opaline
