// Subsurface texture mapping (Francois et al. 2006): single scattering in layers, by a march along the view ray with
// planes in place of the surface. render/techniques/subsurface_texture.md has the derivation and the misprints.
//
// From P the march goes N steps along -w_o to M_max, where the last layer may end below the least-squares plane. At a
// point M the surface is the plane blended between P's tangent plane and that one; light enters it at K. Depth below
// that plane says in which layer M is; the layers along KM are as thick as the mean of M's and K's texels.
#pragma once

#include "render/subsurface/layers.h"
#include "render/subsurface/surface_frame.h"

#include <string>
#include <vector>

namespace opaline {

/// A light without extent.
struct MarchLight {
  bool far = true;
  glm::vec3 place{0};  ///< far: unit, towards the light; else its position [mm]
  glm::vec3 power{0};  ///< irradiance on a plane facing it, or intensity

  glm::vec3 towards(const glm::vec3& p) const { return far ? place : glm::normalize(place - p); }
  glm::vec3 irradiance(const glm::vec3& p) const {
    return far ? power : power / std::max(glm::dot(place - p, place - p), 1e-30f);
  }
};

/// The scene's lights; those of no power are left out. Only for scenes that march_not_applicable lets pass.
std::vector<MarchLight> march_lights(const Scene& scene);

/// Empty if all lights are directional without extent, or points; else why not.
std::string march_not_applicable(const Scene& scene);

/// Which of the lights (bit by bit, the first 24) reach a point's surroundings: one shadow ray each. A point that faces
/// away from a light only asks whether another object stands before it, as its planes know the rest.
std::uint32_t visible_lights(const RayScene& rays, const VisiblePoint& p, const glm::vec3& face_normal,
                             const std::vector<MarchLight>& lights, std::uint64_t& rays_cast);
inline constexpr std::size_t most_march_lights = 24;  ///< bits that a float holds exactly

struct MarchSettings {
  int samples = 50;          ///< N
  bool by_pieces = true;     ///< march=pieces: light fades along a step as it does; false: the paper's sum of samples
  float negligible = 1e-4f;  ///< transmittance at which a march ends; 0: never
};

/// What one object's march needs at every point.
struct MarchMedium {
  const LayeredMedium* textures = nullptr;
  LayerStack stack;         ///< of the layers that have any thickness
  std::vector<int> layers;  ///< which of the textures' layers those are
  float largest_depth = 0;  ///< Depth_max [mm]

  MarchMedium() = default;
  explicit MarchMedium(const LayeredMedium& medium);
  /// Depths at which the layers of the stack end [mm].
  void boundaries(const glm::vec2& uv, float* out) const {
    float all[LayeredMedium::most_layers];
    textures->boundaries(uv, all);
    for (std::size_t k = 0; k < layers.size(); ++k) out[k] = all[layers[k]];
  }
};

/// Below this cosine of the view with the plane the march would go on for ever: it is then taken to be this.
inline constexpr float least_view_cosine = 0.02f;

struct MarchCounts {
  std::uint64_t samples = 0, light_paths = 0, samples_negligible = 0, light_paths_from_behind = 0;
  std::uint64_t shadow_rays = 0, light_paths_shadowed = 0;
  std::uint64_t grazing_points = 0;  ///< seen along the plane: the tangent plane stands in, or the least cosine
  int deepest = 0;                   ///< number of layers any march has got to

  MarchCounts& operator+=(const MarchCounts& o) {
    samples += o.samples, light_paths += o.light_paths, samples_negligible += o.samples_negligible;
    light_paths_from_behind += o.light_paths_from_behind, grazing_points += o.grazing_points;
    shadow_rays += o.shadow_rays, light_paths_shadowed += o.light_paths_shadowed;
    deepest = std::max(deepest, o.deepest);
    return *this;
  }
};

/// Radiance towards the viewer; light l counts if bit l of `visible` is set.
glm::vec3 march(const FramedPoint& p, const MarchMedium& medium, const std::vector<MarchLight>& lights,
                std::uint32_t visible, const MarchSettings& settings, MarchCounts& counts);

}  // namespace opaline
