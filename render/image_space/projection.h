// A centre of projection: from the world to the film of a camera or a light.
//
// Camera coordinates [mm]: x to the right, y up, z the way it looks. Film coordinates in pixels, y down, pixel
// centres at +0.5:
//   perspective    film = (cx + s x/z, cy - s y/z)
//   orthographic   film = (cx + s x,   cy - s y)
// Depth is stored so that it is linear on the film for a plane: 1/z for a perspective view, z for an orthographic one.
#pragma once

#include "render/visibility/gbuffer.h"

#include <cmath>

namespace opaline {

struct Projection {
  glm::dvec3 origin{0};
  glm::dmat3 to_camera{1};
  bool perspective = false;
  float scale = 1;       ///< s [pixels] or [pixels/mm]
  float cx = 0, cy = 0;  ///< [pixels]

  glm::vec3 point(const glm::vec3& world) const { return glm::vec3(to_camera * (glm::dvec3(world) - origin)); }
  glm::vec3 direction(const glm::vec3& world) const { return glm::vec3(to_camera * glm::dvec3(world)); }
  /// Pixels that a length of 1 mm across the view covers at a depth z [mm].
  float pixels_per_mm(float z) const { return perspective ? scale / z : scale; }
};

inline Projection projection_of(const Camera& camera, int width, int height) {
  const CameraFrame frame = camera_frame(camera);
  Projection p;
  p.origin = camera.position;
  p.to_camera = glm::transpose(glm::dmat3(frame.right, frame.up, frame.forward));
  p.perspective = camera.type == Camera::Type::perspective;
  p.scale =
      static_cast<float>(p.perspective ? height / (2 * std::tan(camera.fov_y_deg * pi / 360)) : height / camera.height);
  p.cx = 0.5f * static_cast<float>(width), p.cy = 0.5f * static_cast<float>(height);
  return p;
}

}  // namespace opaline
