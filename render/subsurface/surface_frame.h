// What subsurface texture mapping knows of a surface beforehand (Francois et al. 2006, sections 2.1 and 2.2), per
// vertex, and of one point of it, interpolated.
//
// Plane. The least-squares plane of the vertices within a radius of a vertex: what the surface looks like from deep
// inside. It is given by its unit normal, turned to the vertex normal's side, and by its height over the vertex along
// the vertex normal. A neighbourhood of fewer than three vertices, or of vertices in a line, or whose plane is turned
// from the normal by more than 80 degrees, has no plane: the tangent plane stands in, and is counted.
//
// Tangent frame. The gradients of u and v over the surface [1/mm]: how texture coordinates change with a step. They are
// right for mirrored coordinates too. A vertex without area in texture space has gradient 0, and is counted.
#pragma once

#include "render/counters.h"
#include "render/scene/mesh.h"
#include "render/visibility/gbuffer.h"

namespace opaline {

struct SurfaceFrames {
  std::vector<glm::vec3> plane_normal;
  std::vector<float> plane_height;  ///< [mm]
  std::vector<glm::vec3> gradient_u, gradient_v;
  std::uint64_t neighbours = 0, without_plane = 0, without_gradient = 0;
};

/// The mesh has texture coordinates. radius > 0 [mm].
SurfaceFrames make_surface_frames(const Mesh& mesh, double radius);

/// A visible point with all that is interpolated over its triangle.
struct FramedPoint {
  glm::vec3 position, normal, w_o;
  glm::vec3 plane_normal;
  float plane_height;
  glm::vec2 uv;
  glm::vec3 gradient_u, gradient_v;

  glm::vec2 uv_at(const glm::vec3& step) const {
    return uv + glm::vec2(glm::dot(gradient_u, step), glm::dot(gradient_v, step));
  }
};
FramedPoint framed_point(const Mesh& mesh, const SurfaceFrames& frames, const VisiblePoint& p);

}  // namespace opaline
