// Rays of subsurface texture mapping: which lights a point sees, and what it has of the other side of a thin part, of
// which its planes know nothing. Not in the paper, whose planes leave such parts dark.
//
// The view ray ends where it leaves the object. Light that the tangent plane turns away from, or nearly so, comes in on
// the far side: a ray from a mean free path below the point to the light finds where, and the facet there is the plane
// at which that light enters, for all samples of the march.
#pragma once

#include "render/subsurface/march.h"
#include "render/visibility/ray_scene.h"

namespace opaline {

/// Below this cosine with the tangent plane light is looked for on the far side: so long a way near the surface a plane
/// gets wrong, if it bends away.
inline constexpr float least_light_cosine = 0.15f;

/// Lights (bit by bit) on the outer side of the tangent plane, and of the facet.
std::uint32_t facing_lights(const FramedPoint& p, const glm::vec3& face_normal, std::span<const MarchLight> lights);

/// Which of the lights that are asked for reach a point's surroundings: one shadow ray each. A point whose facet faces
/// away from a light only asks whether another object stands before it, as its planes know the rest.
std::uint32_t visible_lights(const RayScene& rays, const VisiblePoint& p, const glm::vec3& face_normal,
                             std::span<const MarchLight> lights, std::uint32_t asked, std::uint64_t& rays_cast);

struct FarSideTask {
  const RayScene& rays;
  const Mesh& mesh;
  int object;
  const MarchMedium& medium;
  std::span<const MarchLight> lights;
  float negligible;  ///< transmittance: what is surely less isn't marched; 0: all is
  bool shadows;      ///< is it asked whether anything stands before the far side?
};

/// Sets the point's exit, and for the lights of `behind` where they come in, which makes them visible.
void find_far_sides(const FarSideTask& task, std::uint32_t behind, MarchPoint& p, std::uint64_t& rays_cast);

}  // namespace opaline
