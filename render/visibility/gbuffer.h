// What the camera sees: one surface point per pixel centre. Made once per camera, shared by every
// technique and by the fit.
#pragma once

#include "render/counters.h"
#include "render/visibility/ray_scene.h"

#include <vector>

namespace opaline {

/// Ray of a pixel position (pixel centres at +0.5, y down), world frame [mm].
struct CameraRay {
  glm::dvec3 origin, direction;
};
CameraRay camera_ray(const Camera& camera, const Film& film, double x, double y);

/// One pixel that sees an object.
struct VisiblePoint {
  std::uint32_t pixel;  ///< y * width + x
  std::int32_t object;
  std::uint32_t triangle;
  glm::vec3 position;  ///< mm
  glm::vec3 normal;    ///< shading normal, outward
  float cos_o;         ///< n . w_o in (0, 1]
  glm::vec3 w_o{0};    ///< unit, towards the viewer
};

struct GBuffer {
  int width = 0, height = 0;
  std::vector<VisiblePoint> points;  ///< only pixels on an object, in scanline order
  Counters counters;
};

GBuffer make_gbuffer(const Scene& scene, const RayScene& rays);

}  // namespace opaline
