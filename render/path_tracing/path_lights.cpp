#include "render/path_tracing/path_lights.h"

#include <cmath>

namespace opaline {
namespace {

const DirectionalLight* as_disk(const Light& light) {
  const auto* directional = std::get_if<DirectionalLight>(&light);
  return directional && directional->angular_radius_deg > 0 ? directional : nullptr;
}

PointOrDirection near_light(const Light& light) {
  if (const auto* point = std::get_if<PointLight>(&light)) return {false, point->position};
  const auto& projector = std::get<ProjectorLight>(light);
  PointOrDirection where{false, projector.position};
  where.axis = glm::normalize(projector.look_at - projector.position);
  where.half_angle = projector.disk_radius_deg * pi / 180;
  if (projector.image) {
    const double up = std::tan(projector.fov_y_deg * pi / 360);
    where.half_angle = std::atan(up * std::hypot(1.0, static_cast<double>(projector.image->width) /
                                                          static_cast<double>(projector.image->height)));
  }
  where.half_angle += 1e-6;  // its edge is the image's business
  return where;
}

bool is_near(const Light& light) {
  return std::holds_alternative<PointLight>(light) || std::holds_alternative<ProjectorLight>(light);
}

}  // namespace

PathLights::PathLights(const Scene& scene) : scene_(scene), sampler_(scene, 1) {}

bool PathLights::is_environment(std::size_t light) const {
  return std::holds_alternative<EnvironmentLight>(scene_.lights[light]);
}

Lamp PathLights::lamp(std::size_t light, RandomStream& random) const {
  if (is_near(scene_.lights[light])) return {near_light(scene_.lights[light])};
  const LightSample sample = sampler_.sample(light, glm::vec3(0), random.bits());
  return {{true, glm::normalize(glm::dvec3(sample.direction))}, Rgb(sample.irradiance)};
}

std::pair<PointOrDirection, double> PathLights::reach(std::size_t light) const {
  const Light& any = scene_.lights[light];
  if (is_near(any)) return {near_light(any), 0};
  const auto& directional = std::get<DirectionalLight>(any);
  return {{true, -directional.direction}, directional.angular_radius_deg * pi / 180};
}

Rgb PathLights::power(std::size_t light, const Lamp& lamp, const glm::dvec3& point) const {
  if (lamp.where.far) return lamp.irradiance;
  const LightSample sample = sampler_.sample(light, glm::vec3(point), 0);
  const double distance = glm::length(lamp.where.place - point);
  return Rgb(sample.irradiance) * (distance * distance);
}

Rgb PathLights::radiance(const glm::dvec3& w, bool environments, bool disks) const {
  Rgb sum(0);
  for (const Light& light : scene_.lights) {
    const auto* environment = std::get_if<EnvironmentLight>(&light);
    if (environment && environments) sum += environment_radiance(*environment, w);
    const DirectionalLight* disk = disks ? as_disk(light) : nullptr;
    if (!disk) continue;
    const double sine = std::sin(disk->angular_radius_deg * pi / 180), cosine = -glm::dot(disk->direction, w);
    if (cosine > 0 && (1 - cosine) * (1 + cosine) < sine * sine) sum += disk->irradiance / (pi * sine * sine);
  }
  return sum;
}

}  // namespace opaline
