#include "render/visibility/convexity.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>

namespace opaline {
namespace {

/// Index of the first vertex at each vertex's position.
std::vector<std::uint32_t> weld(const Mesh& mesh) {
  std::vector<std::uint32_t> order(mesh.positions.size()), first(order.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto key = [&](std::uint32_t i) {
    const glm::vec3& p = mesh.positions[i];
    return std::tuple(p.x, p.y, p.z);
  };
  std::sort(order.begin(), order.end(),
            [&](std::uint32_t a, std::uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
  for (std::size_t i = 0; i < order.size(); ++i)
    first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
  return first;
}

struct Edge {
  std::uint32_t low, high;  ///< welded vertices
  std::uint32_t triangle;
  std::uint32_t opposite;  ///< the triangle's third vertex
};

std::vector<Edge> sorted_edges(const Mesh& mesh, const std::vector<std::uint32_t>& welded) {
  std::vector<Edge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t a = welded[mesh.triangles[t][k]], b = welded[mesh.triangles[t][(k + 1) % 3]],
                          c = welded[mesh.triangles[t][(k + 2) % 3]];
      edges.push_back({std::min(a, b), std::max(a, b), t, c});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::tuple(a.low, a.high, a.triangle) < std::tuple(b.low, b.high, b.triangle);
  });
  return edges;
}

/// Height of a point above the plane of a triangle, outwards.
float height_above(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& point) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 a = mesh.positions[t.x];
  return glm::dot(glm::normalize(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a)), point - a);
}

/// Sets of triangles that hang together.
class Components {
 public:
  explicit Components(std::size_t count) : parent_(count), left_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = root(a), b = root(b);
    if (a != b) parent_[a] = b, --left_;
  }
  std::size_t count() const { return left_; }

 private:
  std::uint32_t root(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  std::vector<std::uint32_t> parent_;
  std::size_t left_;
};

float extent(const Mesh& mesh) {
  glm::vec3 lo(mesh.positions.front()), hi(lo);
  for (const glm::vec3& p : mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  return glm::length(hi - lo);
}

}  // namespace

// A closed connected surface that is convex at every edge is convex as a whole (Van Heijenoort 1952).
bool is_convex(const Mesh& mesh) {
  if (mesh.triangles.size() < 4) return false;
  const std::vector<Edge> edges = sorted_edges(mesh, weld(mesh));
  if (edges.size() % 2 != 0) return false;
  const float tolerance = 1e-5f * extent(mesh);
  Components components(mesh.triangles.size());
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    const Edge &a = edges[i], &b = edges[i + 1];
    if (a.low != b.low || a.high != b.high) return false;  // an edge of one triangle, or of three
    if (!(height_above(mesh, a.triangle, mesh.positions[b.opposite]) <= tolerance)) return false;
    components.join(a.triangle, b.triangle);
  }
  return components.count() == 1;
}

bool nothing_in_shadow(const Scene& scene) { return scene.objects.size() == 1 && is_convex(scene.objects[0].mesh); }

}  // namespace opaline
