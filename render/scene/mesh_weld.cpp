#include "render/scene/mesh_weld.h"

#include "model/conventions.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

namespace opaline {
namespace {

using Index = std::uint32_t;
constexpr Index none = 0xffffffffu;

std::uint32_t bits(float value) { return std::bit_cast<std::uint32_t>(value + 0.0f); }  // -0 and 0 are one

template <std::size_t N>
std::size_t hash(const std::array<std::uint32_t, N>& key) {
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  for (std::uint32_t word : key) {
    h = (h ^ word) * 0xff51afd7ed558ccdull;
    h ^= h >> 32;
  }
  return static_cast<std::size_t>(h);
}

/// For each key the number of its class of equals, classes numbered in order of first appearance.
template <std::size_t N>
std::vector<Index> class_of_equals(const std::vector<std::array<std::uint32_t, N>>& keys) {
  const std::size_t mask = std::bit_ceil(2 * keys.size() + 1) - 1;
  std::vector<Index> slots(mask + 1, none), classes(keys.size());
  Index count = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::size_t slot = hash(keys[i]) & mask;
    while (slots[slot] != none && keys[slots[slot]] != keys[i]) slot = (slot + 1) & mask;
    if (slots[slot] == none) {
      slots[slot] = static_cast<Index>(i);
      classes[i] = count++;
    } else {
      classes[i] = classes[slots[slot]];
    }
  }
  return classes;
}

std::vector<Index> weld_positions(const std::vector<glm::vec3>& positions) {
  std::vector<std::array<std::uint32_t, 3>> keys;
  keys.reserve(positions.size());
  for (const glm::vec3& p : positions) keys.push_back({bits(p.x), bits(p.y), bits(p.z)});
  return class_of_equals(keys);
}

/// Sets of corners that share one smooth normal.
class CornerSets {
 public:
  explicit CornerSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), Index{0}); }
  Index root(Index corner) {
    while (parent_[corner] != corner) corner = parent_[corner] = parent_[parent_[corner]];
    return corner;
  }
  void join(Index a, Index b) { parent_[root(a)] = root(b); }

 private:
  std::vector<Index> parent_;
};

Index next_corner(Index corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

/// A triangle's side as seen from its first corner; `low` < `high` are welded vertices.
struct Edge {
  Index low, high, corner;
};

std::vector<Edge> sorted_edges(const std::vector<Index>& vertex) {
  std::vector<Edge> edges;
  edges.reserve(vertex.size());
  for (Index corner = 0; corner < vertex.size(); ++corner) {
    const auto [low, high] = std::minmax(vertex[corner], vertex[next_corner(corner)]);
    if (low != high) edges.push_back({low, high, corner});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return std::array{a.low, a.high, a.corner} < std::array{b.low, b.high, b.corner};
  });
  return edges;
}

/// Unit normal per triangle; zero where there is no area (or a vertex is not finite).
std::vector<glm::dvec3> face_normals(const std::vector<glm::vec3>& p) {
  std::vector<glm::dvec3> normals(p.size() / 3, glm::dvec3(0));
  for (std::size_t t = 0; t < normals.size(); ++t) {
    const glm::dvec3 a(p[3 * t]), b(p[3 * t + 1]), c(p[3 * t + 2]);
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double length = glm::length(n);
    if (length > 0 && std::isfinite(length)) normals[t] = n / length;
  }
  return normals;
}

/// Joins the corners on both sides of every edge that is flat enough.
CornerSets smooth_sets(const std::vector<Index>& vertex, const std::vector<glm::dvec3>& faces, double crease_deg) {
  CornerSets sets(vertex.size());
  const std::vector<Edge> edges = sorted_edges(vertex);
  const double limit = std::cos(crease_deg * pi / 180);
  const auto join_at = [&](Index vertex_id, const Edge& a, const Edge& b) {
    const auto corner_at = [&](const Edge& e) {
      return vertex[e.corner] == vertex_id ? e.corner : next_corner(e.corner);
    };
    sets.join(corner_at(a), corner_at(b));
  };
  for (std::size_t i = 0; i < edges.size(); ++i) {
    // More than two triangles at an edge are rare: the window of 8 bounds the cost of a bad mesh.
    for (std::size_t j = i + 1; j < std::min(edges.size(), i + 8); ++j) {
      const Edge &a = edges[i], &b = edges[j];
      if (a.low != b.low || a.high != b.high) break;
      if (glm::dot(faces[a.corner / 3], faces[b.corner / 3]) < limit) continue;
      join_at(a.low, a, b);
      join_at(a.high, a, b);
    }
  }
  return sets;
}

double corner_angle(const std::vector<glm::vec3>& p, Index corner) {
  const Index second = next_corner(corner), third = next_corner(second);
  const glm::dvec3 u = glm::dvec3(p[second]) - glm::dvec3(p[corner]), v = glm::dvec3(p[third]) - glm::dvec3(p[corner]);
  return std::atan2(glm::length(glm::cross(u, v)), glm::dot(u, v));
}

std::vector<glm::vec3> smooth_normals(const std::vector<glm::vec3>& positions, double crease_deg) {
  const std::vector<glm::dvec3> faces = face_normals(positions);
  CornerSets sets = smooth_sets(weld_positions(positions), faces, crease_deg);
  std::vector<glm::dvec3> sums(positions.size(), glm::dvec3(0));
  for (Index c = 0; c < positions.size(); ++c) {
    const glm::dvec3& face = faces[c / 3];
    if (face != glm::dvec3(0)) sums[sets.root(c)] += face * corner_angle(positions, c);
  }
  std::vector<glm::vec3> normals(positions.size());
  for (Index c = 0; c < positions.size(); ++c) {
    const glm::dvec3 sum = sums[sets.root(c)];
    const double length = glm::length(sum);
    // Only a triangle without area has no direction at all; it is rejected or dropped later.
    normals[c] = length > 1e-12 ? glm::vec3(sum / length) : glm::vec3(0, 0, 1);
  }
  return normals;
}

std::vector<glm::vec3> corner_normals(const TriangleSoup& soup, double crease_deg) {
  std::vector<glm::vec3> normals = soup.normals;
  normals.resize(soup.positions.size(), glm::vec3(0));
  std::vector<glm::vec3> smooth;
  for (std::size_t c = 0; c < normals.size(); ++c) {
    const double length = glm::length(glm::dvec3(normals[c]));
    if (length == 0) {
      if (smooth.empty()) smooth = smooth_normals(soup.positions, crease_deg);
      normals[c] = smooth[c];
    } else {
      normals[c] = glm::vec3(glm::dvec3(normals[c]) / length);
    }
  }
  return normals;
}

}  // namespace

Mesh weld_soup(const TriangleSoup& soup, double crease_deg) {
  const std::vector<glm::vec3> normals = corner_normals(soup, crease_deg);
  const bool has_uvs = !soup.uvs.empty();
  std::vector<std::array<std::uint32_t, 8>> keys;
  keys.reserve(soup.positions.size());
  for (std::size_t c = 0; c < soup.positions.size(); ++c) {
    const glm::vec3 p = soup.positions[c], n = normals[c];
    const glm::vec2 uv = has_uvs ? soup.uvs[c] : glm::vec2(0);
    keys.push_back({bits(p.x), bits(p.y), bits(p.z), bits(n.x), bits(n.y), bits(n.z), bits(uv.x), bits(uv.y)});
  }
  const std::vector<Index> vertex = class_of_equals(keys);
  Mesh mesh;
  for (std::size_t c = 0; c < vertex.size(); ++c) {
    if (vertex[c] < mesh.positions.size()) continue;
    mesh.positions.push_back(soup.positions[c]);
    mesh.normals.push_back(normals[c]);
    if (has_uvs) mesh.uvs.push_back(soup.uvs[c]);
  }
  for (std::size_t c = 0; c + 2 < vertex.size(); c += 3) {
    mesh.triangles.push_back({vertex[c], vertex[c + 1], vertex[c + 2]});
  }
  return mesh;
}

}  // namespace opaline
