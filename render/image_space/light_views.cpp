#include "render/image_space/light_views.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

struct Ball {
  glm::dvec3 centre;
  double radius;
};

/// Around the bounding box of all objects, a little larger.
Ball bounds(const Scene& scene) {
  glm::vec3 lo(1e30f), hi(-lo);
  for (const Object& object : scene.objects)
    for (const glm::vec3& p : object.mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  return {0.5 * glm::dvec3(lo + hi), 0.505 * static_cast<double>(glm::length(hi - lo))};
}

glm::dvec3 any_up(const glm::dvec3& forward) {
  return std::abs(forward.y) < 0.9 ? glm::dvec3(0, 1, 0) : glm::dvec3(1, 0, 0);
}

Camera along(const DirectionalLight& light, const Ball& ball) {
  Camera camera;
  camera.type = Camera::Type::orthographic;
  camera.position = ball.centre - 2 * ball.radius * light.direction;
  camera.look_at = ball.centre;
  camera.up = any_up(light.direction);
  camera.height = 2 * ball.radius;
  return camera;
}

std::optional<Camera> from(const glm::dvec3& position, const Ball& ball) {
  const double sine = ball.radius / glm::length(ball.centre - position);
  if (!(sine < std::sin(pi / 3))) return std::nullopt;
  Camera camera;
  camera.position = position;
  camera.look_at = ball.centre;
  camera.up = any_up(glm::normalize(ball.centre - position));
  camera.fov_y_deg = 2 * std::asin(sine) * 180 / pi;
  return camera;
}

}  // namespace

std::optional<Camera> light_camera(const Light& light, const Scene& scene) {
  const Ball ball = bounds(scene);
  if (const auto* l = std::get_if<DirectionalLight>(&light)) return along(*l, ball);
  if (const auto* l = std::get_if<PointLight>(&light)) return from(l->position, ball);
  if (const auto* l = std::get_if<ProjectorLight>(&light)) return from(l->position, ball);
  return std::nullopt;
}

std::vector<GBuffer> light_views(const Scene& scene, const RayScene& rays, int pixels, Counters& counters) {
  std::vector<GBuffer> views;
  for (const Light& light : scene.lights) {
    if (const std::optional<Camera> camera = light_camera(light, scene))
      views.push_back(make_gbuffer(scene, *camera, {pixels, pixels}, rays));
    else
      ++counters.skipped["lights_without_a_view"];
  }
  counters.done["light_views"] += views.size();
  return views;
}

}  // namespace opaline
