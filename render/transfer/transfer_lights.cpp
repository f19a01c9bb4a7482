#include "render/transfer/transfer_lights.h"

#include "render/irradiance/light_sampler.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace opaline {
namespace {

constexpr int sky_columns = 128, sky_rows = 64;

struct SkyPart {
  Rgb irradiance{0};
  glm::dvec3 direction{0};
};

/// The sky in parts: each the light that comes from it, and the mean direction of that light.
void add_sky(const EnvironmentLight& sky, std::vector<TransferLight>& lights) {
  const int finer_x = std::max(1, 2 * sky_columns / sky.image->width), width = finer_x * sky.image->width;
  const int finer_y = std::max(1, 2 * sky_rows / sky.image->height), height = finer_y * sky.image->height;
  std::vector<SkyPart> parts(sky_columns * sky_rows);
  for (int y = 0; y < height; ++y) {
    const double top = pi * y / height, bottom = pi * (y + 1) / height, theta = 0.5 * (top + bottom);
    const double solid_angle = (std::cos(top) - std::cos(bottom)) * 2 * pi / width;
    for (int x = 0; x < width; ++x) {
      const double phi = 2 * pi * ((x + 0.5) / width - 0.5);
      const glm::dvec3 w(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
      const Rgb irradiance = solid_angle * environment_radiance(sky, w);
      SkyPart& part = parts[static_cast<std::size_t>(sky_rows * y / height * sky_columns + sky_columns * x / width)];
      part.irradiance += irradiance;
      part.direction += (irradiance.r + irradiance.g + irradiance.b) * w;
    }
  }
  for (const SkyPart& part : parts)
    if (glm::length(part.direction) > 0) lights.push_back({glm::normalize(part.direction), 0, part.irradiance});
}

void add_disk(const DirectionalLight& light, int samples, std::vector<TransferLight>& lights) {
  const int n = light.angular_radius_deg > 0 ? samples : 1;
  const glm::dvec3 axis = -light.direction;
  const glm::dvec3 s =
      glm::normalize(glm::cross(axis, std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
  for (int k = 0; k < n; ++k) {
    // Uniform in projected solid angle around the axis, as LightSampler takes it.
    const double sine = n == 1 ? 0 : std::sin(light.angular_radius_deg * pi / 180) * std::sqrt((k + 0.5) / n);
    const double cosine = std::sqrt(1 - sine * sine), phi = k * pi * (3 - std::sqrt(5.0));
    const glm::dvec3 d = cosine * axis + sine * (std::cos(phi) * s + std::sin(phi) * glm::cross(axis, s));
    lights.push_back({d, 0, light.irradiance / (n * std::max(cosine, 1e-9))});
  }
}

void add_point(const PointLight& light, const TransferNodes& nodes, std::vector<TransferLight>& lights) {
  const glm::dvec3 d = light.position - nodes.middle;
  const double distance = glm::length(d);
  lights.push_back({d / distance, nodes.radius / distance, light.intensity / (distance * distance)});
}

/// Calls add(node, weight) for the nodes around a light.
template <typename Add>
void for_nodes(const TransferLight& light, const TransferNodes& nodes, const Add& add) {
  const auto [level, above] = nodes.level_of(light.u);
  for (const DirectionWeight& d : nodes.directions.around(light.direction))
    for (int step = 0; step < 2; ++step) {
      const double weight = d.weight * (step ? above : 1 - above);
      if (weight != 0) add(static_cast<std::uint32_t>(level + step) * nodes.per_level() + d.direction, weight);
    }
}

std::vector<KeyWeight> listed(const std::map<std::uint32_t, Rgb>& weights) {
  std::vector<KeyWeight> list;
  for (const auto& [key, weight] : weights)
    if (weight != Rgb(0)) list.push_back({key, weight});
  return list;
}

}  // namespace

std::pair<int, double> TransferNodes::level_of(double u) const {
  if (levels == 1) return {0, 0};
  const double place = std::clamp(u / level_step(), 0.0, levels - 1.0);
  const int level = std::min(static_cast<int>(place), levels - 2);
  return {level, place - level};
}

TransferNodes transfer_nodes(const Mesh& mesh, int directions, int levels, DirectionInterpolation interpolation) {
  glm::vec3 lo(mesh.positions.front()), hi(lo);
  for (const glm::vec3& p : mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  return {0.5 * glm::dvec3(lo + hi), 0.5 * glm::length(glm::dvec3(hi) - glm::dvec3(lo)),
          DirectionSet(directions, interpolation), levels};
}

std::vector<TransferLight> transfer_lights(const Scene& scene, const TransferNodes& nodes, int area_samples) {
  std::vector<TransferLight> lights;
  for (const Light& light : scene.lights) {
    if (const auto* l = std::get_if<DirectionalLight>(&light)) add_disk(*l, area_samples, lights);
    if (const auto* l = std::get_if<PointLight>(&light)) add_point(*l, nodes, lights);
    if (const auto* l = std::get_if<EnvironmentLight>(&light)) add_sky(*l, lights);
  }
  std::erase_if(lights, [](const TransferLight& l) { return l.irradiance == Rgb(0); });
  return lights;
}

std::vector<KeyWeight> node_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes) {
  std::map<std::uint32_t, Rgb> weights;
  for (const TransferLight& light : lights)
    for_nodes(light, nodes, [&](std::uint32_t node, double w) { weights[node] += w * light.irradiance; });
  return listed(weights);
}

std::vector<KeyWeight> vector_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes) {
  std::map<std::uint32_t, Rgb> weights;
  for (const TransferLight& light : lights)
    for_nodes(light, nodes, [&](std::uint32_t node, double w) {
      for (int axis = 0; axis < 3; ++axis)
        weights[3 * node + static_cast<std::uint32_t>(axis)] += w * light.direction[axis] * light.irradiance;
    });
  return listed(weights);
}

std::string transfer_lights_not_applicable(const Scene& scene) {
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const Light& light = scene.lights[i];
    if (std::holds_alternative<ProjectorLight>(light))
      return fmt::format("/lights/{} is a projector; the table knows directional, point and environment lights", i);
    const auto* point = std::get_if<PointLight>(&light);
    for (std::size_t k = 0; point && k < scene.objects.size(); ++k) {
      const TransferNodes ball = transfer_nodes(scene.objects[k].mesh, DirectionSet::fewest, 1);
      const double distance = glm::length(point->position - ball.middle),
                   least = ball.radius / TransferNodes::nearest_u;
      if (distance < least)
        return fmt::format(
            "/lights/{} is {:.4g} mm from the middle of /objects/{}; the table of point lights begins at {:.4g} mm", i,
            distance, k, least);
    }
  }
  return {};
}

}  // namespace opaline
