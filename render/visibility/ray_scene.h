// Intersection of rays with a scene's triangles (Embree). Intersection only: no shading.
#pragma once

#include "render/scene/scene.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <memory>

namespace opaline {

struct SurfaceHit {
  std::int32_t object = -1;  ///< -1: nothing was hit
  std::uint32_t triangle = 0;
  float u = 0, v = 0;  ///< barycentrics of the triangle's second and third vertex
  float distance = 0;  ///< mm
};

class RayScene {
 public:
  explicit RayScene(const Scene& scene);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// The first hit at a distance of at least `near`.
  SurfaceHit closest(const glm::vec3& origin, const glm::vec3& direction, float near = 0) const;
  /// Is anything between the origin and `distance` along the unit direction?
  bool occluded(const glm::vec3& origin, const glm::vec3& direction, float distance) const;
  /// How far to move a ray's origin off its surface [mm]: 1e-5 of the scene's diagonal.
  float offset() const { return offset_; }

 private:
  struct Handles;
  std::unique_ptr<Handles> handles_;
  float offset_ = 0;
};

/// Point, face normal and shading normal of a triangle at barycentrics (u, v).
struct SurfacePoint {
  glm::vec3 position, face_normal, normal;
};
SurfacePoint surface_point(const Mesh& mesh, std::uint32_t triangle, float u, float v);

/// The same at a position in the triangle's plane.
SurfacePoint surface_point_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position);

}  // namespace opaline
