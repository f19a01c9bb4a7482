#include "render/path_tracing/interior.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <unordered_map>

namespace opaline {
namespace {

/// Vertices of equal position have the number of the first of them.
std::vector<std::uint32_t> positions_joined(const Mesh& mesh) {
  struct Hash {
    std::size_t operator()(const std::array<float, 3>& p) const {
      std::size_t h = 0;
      for (const float x : p) {
        std::uint32_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        h = (h ^ bits) * 0x9e3779b97f4a7c15ull;
        h ^= h >> 29;
      }
      return h;
    }
  };
  std::unordered_map<std::array<float, 3>, std::uint32_t, Hash> first;
  std::vector<std::uint32_t> joined;
  joined.reserve(mesh.positions.size());
  for (const glm::vec3& p : mesh.positions) {
    const std::array<float, 3> key = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f};  // -0 is 0
    joined.push_back(first.emplace(key, static_cast<std::uint32_t>(joined.size())).first->second);
  }
  return joined;
}

/// Edges used more often one way than the other.
std::size_t open_edges(const Mesh& mesh) {
  const std::vector<std::uint32_t> joined = positions_joined(mesh);
  std::unordered_map<std::uint64_t, int> balance;
  for (const glm::uvec3& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const std::uint64_t a = joined[t[k]], b = joined[t[(k + 1) % 3]];
      balance[std::min(a, b) << 32 | std::max(a, b)] += a < b ? 1 : -1;
    }
  return static_cast<std::size_t>(
      std::count_if(balance.begin(), balance.end(), [](const auto& edge) { return edge.second != 0; }));
}

double signed_volume(const Mesh& mesh) {
  double volume = 0;
  const glm::dvec3 origin(mesh.positions.front());
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    volume += glm::dot(a - origin, glm::cross(b - origin, c - origin)) / 6;
  }
  return volume;
}

}  // namespace

Interior::Interior(const Scene& scene, const RayScene& rays, int object)
    : rays_(rays),
      object_(object),
      material_(scene.materials[static_cast<std::size_t>(scene.objects[static_cast<std::size_t>(object)].material)]) {
  const Mesh& mesh = scene.objects[static_cast<std::size_t>(object)].mesh;
  mean_chord_ = 4 * signed_volume(mesh) / surface_area(mesh);
  tree_ = FacetTree(facets_of(mesh));
}

std::optional<BoundaryHit> Interior::boundary(const glm::dvec3& from, const glm::dvec3& direction,
                                              RayCounts& counts) const {
  float near = 0;
  constexpr int most_facets_at_a_point = 64;
  for (int i = 0; i < most_facets_at_a_point; ++i) {
    ++counts.boundary;
    const SurfaceHit hit = rays_.closest(glm::vec3(from), glm::vec3(direction), near);
    if (hit.object < 0) return std::nullopt;
    if (hit.object == object_) {
      const Facet& f = facet(hit.triangle);
      const double cosine = glm::dot(direction, f.normal);
      if (cosine > 0) {
        const double distance = glm::dot(f.corner - from, f.normal) / cosine;  // sharper than the ray's float
        return BoundaryHit{hit.triangle, std::max(0.0, distance)};
      }
    }
    // Denormals are flushed to 0, so they would not get on.
    near = std::max(std::nextafter(hit.distance, std::numeric_limits<float>::infinity()),
                    std::numeric_limits<float>::min());
  }
  return std::nullopt;
}

bool Interior::free_inside(const glm::dvec3& from, const glm::dvec3& direction, double length,
                           RayCounts& counts) const {
  const double until = length - static_cast<double>(rays_.offset());
  if (until <= 0) return true;
  ++counts.shadow;
  return !rays_.occluded(glm::vec3(from), glm::vec3(direction), static_cast<float>(until));
}

bool Interior::free_outside(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& direction,
                            double length, RayCounts& counts) const {
  ++counts.shadow;
  const auto offset = static_cast<double>(rays_.offset());
  return !rays_.occluded(glm::vec3(point + offset * normal), glm::vec3(direction), static_cast<float>(length));
}

std::string closed_mesh_fault(const Mesh& mesh) {
  if (const std::size_t open = open_edges(mesh))
    return fmt::format("its mesh is not closed ({} {} not shared by two triangles of the same orientation)", open,
                       open == 1 ? "edge is" : "edges are");
  if (!(signed_volume(mesh) > 0)) return "its mesh is inside out (its volume is not positive)";
  return {};
}

}  // namespace opaline
