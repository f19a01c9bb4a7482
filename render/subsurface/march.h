// Subsurface texture mapping (Francois et al. 2006): single scattering in layers, by a march along the view ray with
// planes in place of the surface. render/techniques/subsurface_texture.md has the derivation and the misprints.
//
// From P the march goes N steps along -w_o to M_max, where the last layer may end below the least-squares plane. At a
// point M the surface is the plane blended between P's tangent plane and that one; light enters it at K. Depth below
// that plane says in which layer M is; the layers along KM are as thick as the mean of M's and K's texels. march.glsl
// is the march itself, for shaders and for vectors of points.
#pragma once

#include "render/subsurface/layer_texture.h"
#include "render/subsurface/layers.h"
#include "render/subsurface/surface_frame.h"

#include <span>
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

inline constexpr std::size_t most_march_lights = 24;  ///< bits that a float holds exactly

struct MarchSettings {
  int samples = 50;          ///< N
  bool by_pieces = true;     ///< march=pieces: light fades along a step as it does; false: the paper's sum of samples
  float negligible = 1e-4f;  ///< transmittance at which a march ends; 0: never
};

/// What one object's march needs at every point.
struct MarchMedium {
  const LayeredMedium* source = nullptr;
  MediumLayers stack;                  ///< of the layers that have any thickness
  std::vector<int> layers;             ///< which of the source's layers those are
  std::vector<LayerTexture> textures;  ///< where they end, one after the other
  float largest_depth = 0;             ///< Depth_max [mm]
  /// Of each layer, for march.glsl's phase().
  std::array<glm::vec4, LayeredMedium::most_layers + 1> phases{};

  MarchMedium() = default;
  explicit MarchMedium(const LayeredMedium& medium);
};

/// Below this cosine of the view with the plane the march would go on for ever: it is then taken to be this.
inline constexpr float least_view_cosine = 0.02f;

/// Where light enters on the far side of an object from a point: a plane and its texture coordinates.
struct FarSide {
  glm::vec3 normal{0};  ///< outwards; 0: there is none
  float height = 0;     ///< of the plane over the point [mm]
  glm::vec2 uv{0};
};

/// A point ready to march. Its plane is the tangent plane where the view sees the fitted one edge-on.
struct MarchPoint : FramedPoint {
  std::uint32_t visible = 0;  ///< lights, bit by bit
  std::uint32_t faded = 0;    ///< other lights, of which the way through the object leaves nothing
  std::uint32_t lights = 0;   ///< those visible that reach some plane of the march; behind both ends' is behind all
  bool grazing = false;       ///< seen along the fitted plane
  float exit = 1e30f;         ///< where the view leaves the object [mm], if it is known
  float exit_cosine = 1;      ///< of the view with the surface there
  std::vector<FarSide> far;   ///< of each light, or empty: far_side.h
};
/// By its planes alone.
MarchPoint march_point(const FramedPoint& p, const MarchMedium& medium, std::span<const MarchLight> lights,
                       std::uint32_t visible);

/// What the march of one point gave, on either backend.
struct MarchResult {
  glm::vec3 radiance{0};  ///< towards the viewer
  float steps = 0, light_paths = 0, from_behind = 0;
  float deepest = 0;  ///< number of layers it has got to
};

struct MarchCounts {
  std::uint64_t samples = 0, light_paths = 0, shadow_rays = 0, far_side_rays = 0;
  std::uint64_t samples_negligible = 0, samples_unlit = 0;  ///< not made: no light left; no light reaches the point
  std::uint64_t from_behind = 0, shadowed = 0, below_layers = 0;  ///< light paths not followed
  std::uint64_t grazing_points = 0;  ///< seen along the plane: the tangent plane stands in, or the least cosine
  int deepest = 0;                   ///< number of layers any march has got to

  /// Each of N + 1 samples at each light, up to where the march ended, is one light path done or not followed.
  void add(const MarchPoint& p, const MarchResult& result, int samples, std::size_t lights);
  MarchCounts& operator+=(const MarchCounts& o);
};

/// Marches points of one object, on as many at once as the processor's vectors hold.
void march(std::span<const MarchPoint> points, const MarchMedium& medium, std::span<const MarchLight> lights,
           const MarchSettings& settings, MarchResult* results);

}  // namespace opaline
