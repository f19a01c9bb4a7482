#include "render/visibility/gbuffer.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace opaline {
namespace {

struct CameraFrame {
  glm::dvec3 right, up, forward;
};

CameraFrame camera_frame(const Camera& camera) {
  const glm::dvec3 forward = glm::normalize(camera.look_at - camera.position);
  const glm::dvec3 right = glm::normalize(glm::cross(forward, camera.up));
  return {right, glm::cross(right, forward), forward};
}

// A shading normal may point away from the viewer near a silhouette; the face normal is used there, and
// its cosine counts as positive when the surface is seen from behind.
VisiblePoint visible_point(std::uint32_t pixel, const SurfaceHit& hit, const Mesh& mesh, const glm::vec3& to_viewer) {
  const SurfacePoint p = surface_point(mesh, hit.triangle, hit.u, hit.v);
  glm::vec3 normal = p.normal;
  float cosine = glm::dot(normal, to_viewer);
  if (cosine <= 0) {
    normal = p.face_normal;
    cosine = std::abs(glm::dot(normal, to_viewer));
  }
  return {pixel, hit.object, hit.triangle, p.position, normal, std::min(std::max(cosine, 1e-6f), 1.0f), to_viewer};
}

}  // namespace

CameraRay camera_ray(const Camera& camera, const Film& film, double x, double y) {
  const CameraFrame frame = camera_frame(camera);
  const double aspect = static_cast<double>(film.width) / film.height;
  const double sx = (2 * x / film.width - 1) * aspect, sy = 1 - 2 * y / film.height;
  if (camera.type == Camera::Type::orthographic) {
    const double half = camera.height / 2;
    return {camera.position + half * (sx * frame.right + sy * frame.up), frame.forward};
  }
  const double half = std::tan(camera.fov_y_deg * pi / 360);
  return {camera.position, glm::normalize(frame.forward + half * (sx * frame.right + sy * frame.up))};
}

GBuffer make_gbuffer(const Scene& scene, const RayScene& rays) {
  GBuffer buffer;
  buffer.width = scene.film.width;
  buffer.height = scene.film.height;
  std::vector<std::vector<VisiblePoint>> rows(static_cast<std::size_t>(buffer.height));
  tbb::parallel_for(0, buffer.height, [&](int y) {
    for (int x = 0; x < buffer.width; ++x) {
      const CameraRay ray = camera_ray(scene.camera, scene.film, x + 0.5, y + 0.5);
      const SurfaceHit hit = rays.closest(glm::vec3(ray.origin), glm::vec3(ray.direction));
      if (hit.object < 0) continue;
      const auto pixel = static_cast<std::uint32_t>(y * buffer.width + x);
      const Mesh& mesh = scene.objects[static_cast<std::size_t>(hit.object)].mesh;
      rows[static_cast<std::size_t>(y)].push_back(visible_point(pixel, hit, mesh, -glm::vec3(ray.direction)));
    }
  });
  for (const auto& row : rows) buffer.points.insert(buffer.points.end(), row.begin(), row.end());
  const auto pixels = static_cast<std::uint64_t>(buffer.width) * static_cast<std::uint64_t>(buffer.height);
  buffer.counters.done["camera_rays"] = pixels;
  buffer.counters.skipped["pixels_off_object"] = pixels - buffer.points.size();
  return buffer;
}

}  // namespace opaline
