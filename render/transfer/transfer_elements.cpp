#include "render/transfer/transfer_elements.h"

#include "model/check.h"
#include "model/fresnel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

/// An equilateral triangle of that area around a point.
SurfaceCell around(const glm::vec3& p, const glm::vec3& normal, double area) {
  const float out = static_cast<float>(std::sqrt(4 * area / (3 * std::sqrt(3.0))));
  const glm::vec3 s = out * glm::normalize(glm::cross(
                                normal, std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0))),
                  t = glm::cross(normal, s);
  const float half_root_3 = 0.8660254f;
  return {p + s, p - 0.5f * s + half_root_3 * t, p - 0.5f * s - half_root_3 * t, 0};
}

/// A node's light, ready for many points.
struct NodeLight {
  glm::dvec3 direction, position;
  double distance;  ///< from the middle; infinite for directional light
  std::size_t column;

  NodeLight(const TransferNodes& nodes, std::uint32_t node, std::size_t first_column)
      : direction(nodes.direction(node)), column(first_column) {
    const double u = nodes.u(node);
    distance = u > 0 ? nodes.radius / u : std::numeric_limits<double>::infinity();
    position = u > 0 ? nodes.middle + distance * direction : glm::dvec3(0);
  }
};

struct Lighting {
  const RayScene& rays;
  bool unshadowed, vectors;
  double eta;
  std::uint64_t done = 0, away = 0, spared = 0;

  /// What a node's light is at a point: from where, how far, how strong, and its cosine, 0 if it meets the back.
  struct Arrival {
    glm::vec3 direction;
    float distance;
    double strength, cosine;
  };
  static Arrival arrival(const SurfacePoint& p, const NodeLight& node) {
    glm::dvec3 w = node.direction;
    double far = node.distance, strength = 1;
    if (std::isfinite(node.distance)) {
      const glm::dvec3 d = node.position - glm::dvec3(p.position);
      far = glm::length(d);
      strength = node.distance * node.distance / (far * far);
      w = d / far;
    }
    const glm::vec3 direction(w);
    const float cosine = glm::dot(p.face_normal, direction) > 0 ? glm::dot(p.normal, direction) : 0;
    return {direction, static_cast<float>(far), strength, std::clamp(static_cast<double>(cosine), 0.0, 1.0)};
  }

  bool visible(const SurfacePoint& p, const Arrival& a) {
    ++(unshadowed ? spared : done);
    return unshadowed || !rays.occluded(p.position + rays.offset() * p.face_normal, a.direction, a.distance);
  }

  void light(std::span<const SurfacePoint> points, const NodeLight& node, float* out) {
    std::array<Arrival, 4> arrivals;
    std::size_t facing = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      arrivals[i] = arrival(points[i], node);
      facing += arrivals[i].cosine > 0;
    }
    if (facing == 0) {
      ++away;
      return;
    }
    const bool together = facing == points.size();
    if (together && !visible(points.back(), arrivals[points.size() - 1])) return;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (arrivals[i].cosine > 0 && (together || visible(points[i], arrivals[i])))
        add(points[i], arrivals[i], 1.0 / static_cast<double>(points.size()), &out[node.column]);
  }

  void add(const SurfacePoint& p, const Arrival& a, double share, float* out) const {
    const double entering = share * a.strength * fresnel_transmittance(a.cosine, eta);
    if (!vectors) out[0] += static_cast<float>(entering * a.cosine);
    for (int axis = 0; vectors && axis < 3; ++axis)
      out[axis] += static_cast<float>(entering * static_cast<double>(p.normal[axis]));
  }
};

}  // namespace

TransferElements cell_elements(const Mesh& mesh, std::size_t count) {
  TransferElements elements{make_surface_cells(mesh, count), {}, false};
  elements.points.reserve(4 * elements.cells.size());
  for (const SurfaceCell& cell : elements.cells) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    for (const SurfaceCell& quarter : quarters)
      elements.points.push_back(surface_point_at(mesh, cell.triangle, cell_centroid(quarter)));
  }
  return elements;
}

TransferElements disc_elements(const TransferVertices& vertices) {
  TransferElements elements;
  elements.discs = true;
  const std::vector<double> areas = vertex_areas(vertices.positions, vertices.triangles);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    const glm::vec3 &p = vertices.positions[v], &n = vertices.normals[v];
    elements.cells.push_back(around(p, n, areas[v]));
    elements.points.push_back({p, n, n});
  }
  return elements;
}

void light_elements(const TransferElements& elements, const TransferColumns& columns,
                    std::span<const std::uint32_t> keys, double eta, const RayScene& rays, bool unshadowed,
                    std::vector<float>& out, Counters& counters) {
  OPALINE_CHECK(keys.size() <= transfer_columns);
  std::vector<NodeLight> lights;
  const std::size_t step = columns.vectors ? 3 : 1;
  for (std::size_t k = 0; k < keys.size(); k += step)
    lights.emplace_back(columns.nodes, keys[k] / static_cast<std::uint32_t>(step), k);
  const std::size_t count = elements.cells.size(), each = elements.points_each();
  out.assign(count * transfer_columns, 0.0f);
  std::atomic<std::uint64_t> done = 0, away = 0, spared = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 256), [&](const auto& range) {
    Lighting lighting{rays, unshadowed, columns.vectors, eta};
    for (std::size_t i = range.begin(); i != range.end(); ++i)
      for (const NodeLight& light : lights)
        lighting.light(std::span(elements.points).subspan(i * each, each), light, &out[i * transfer_columns]);
    done += lighting.done, away += lighting.away, spared += lighting.spared;
  });
  counters.done["shadow_rays"] += done;
  counters.skipped["shadow_rays_facing_away"] += away;
  counters.skipped["shadow_rays_nothing_in_shadow"] += spared;
}

}  // namespace opaline
