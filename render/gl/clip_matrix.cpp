#include "render/gl/clip_matrix.h"

#include <algorithm>

namespace opaline::gl {
namespace {

/// Depths of the bounding box's corners along a view, with a little to spare.
glm::dvec2 depth_range(const Scene& scene, const Projection& view) {
  glm::vec3 lo(1e30f), hi(-lo);
  for (const Object& object : scene.objects)
    for (const glm::vec3& p : object.mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  double near = 1e300, far = -1e300;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 p(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z);
    const double z = static_cast<double>(view.point(p).z);
    near = std::min(near, z), far = std::max(far, z);
  }
  const double margin = 0.01 * (far - near) + 1e-6;
  const double least = near > 0 ? 0.01 * near : 1e-4 * (far + margin);  // a view from inside the box
  return {view.perspective ? std::max(near - margin, least) : near - margin, far + margin};
}

}  // namespace

glm::mat4 clip_matrix(const Scene& scene, const Projection& view, int width, int height) {
  const glm::dvec2 range = depth_range(scene, view);
  const double near = range.x, far = range.y, depth = far - near, scale = 2 * static_cast<double>(view.scale);
  glm::dmat4 clip(0);  // columns
  clip[0][0] = scale / width, clip[1][1] = scale / height;
  if (view.perspective) {
    clip[2][2] = (far + near) / depth, clip[2][3] = 1, clip[3][2] = -2 * far * near / depth;
  } else {
    clip[2][2] = 2 / depth, clip[3][2] = -(far + near) / depth, clip[3][3] = 1;
  }
  glm::dmat4 to_camera(view.to_camera);
  to_camera[3] = glm::dvec4(view.to_camera * -view.origin, 1);
  return glm::mat4(clip * to_camera);
}

}  // namespace opaline::gl
