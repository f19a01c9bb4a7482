#include "render/transfer/transfer_vertices.h"

#include "model/check.h"
#include "render/irradiance/morton.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace opaline {
namespace {

/// Makes the vertices of cut triangles; those on an edge are shared by both of its sides.
class Cutter {
 public:
  Cutter(const Mesh& mesh, int parts, TransferVertices& out) : mesh_(mesh), k_(parts), out_(out) {
    out.positions = mesh.positions;
    out.normals = mesh.normals;
    const bool smooth = !mesh.normals.empty();
    if (!smooth) out.normals.assign(mesh.positions.size(), glm::vec3(0));
    for (const glm::uvec3& t : mesh.triangles) {
      cut(t);
      if (!smooth)  // area-weighted means of the faces
        for (int i = 0; i < 3; ++i)
          out.normals[t[i]] +=
              glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
    }
    for (glm::vec3& n : out.normals) n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 0, 1);
  }

 private:
  /// Vertex at barycentrics (j of the second, i of the third corner) / k.
  std::uint32_t vertex(const glm::uvec3& t, int j, int i) {
    const int first = k_ - i - j;
    if (first == k_) return t.x;
    if (j == k_) return t.y;
    if (i == k_) return t.z;
    if (i == 0) return on_edge(t.x, t.y, j);
    if (j == 0) return on_edge(t.x, t.z, i);
    if (first == 0) return on_edge(t.y, t.z, i);
    return add({t.x, t.y, t.z}, glm::vec3(first, j, i) / static_cast<float>(k_));
  }
  std::uint32_t on_edge(std::uint32_t a, std::uint32_t b, int step) {
    if (a > b) std::swap(a, b), step = k_ - step;
    const auto [it, made] = edges_.try_emplace((std::uint64_t{a} << 32) | b, 0);
    if (made) {
      it->second = static_cast<std::uint32_t>(out_.positions.size());
      for (int s = 1; s < k_; ++s) add({a, b, b}, glm::vec3(k_ - s, s, 0) / static_cast<float>(k_));
    }
    return it->second + static_cast<std::uint32_t>(step - 1);
  }
  std::uint32_t add(const glm::uvec3& t, const glm::vec3& w) {
    const auto mean = [&](const std::vector<glm::vec3>& v) { return w.x * v[t.x] + w.y * v[t.y] + w.z * v[t.z]; };
    out_.positions.push_back(mean(out_.positions));
    out_.normals.push_back(mesh_.normals.empty() ? glm::vec3(0) : mean(mesh_.normals));
    return static_cast<std::uint32_t>(out_.positions.size() - 1);
  }

  void cut(const glm::uvec3& t) {
    if (k_ == 1) return out_.triangles.push_back(t);
    std::vector<std::uint32_t> grid;  // row i holds k - i + 1 vertices
    for (int i = 0; i <= k_; ++i)
      for (int j = 0; i + j <= k_; ++j) grid.push_back(vertex(t, j, i));
    const auto at = [&](int j, int i) { return grid[static_cast<std::size_t>(i * (k_ + 1) - i * (i - 1) / 2 + j)]; };
    for (int i = 0; i < k_; ++i)
      for (int j = 0; i + j < k_; ++j) {
        out_.triangles.push_back({at(j, i), at(j + 1, i), at(j, i + 1)});
        if (i + j + 1 < k_) out_.triangles.push_back({at(j + 1, i + 1), at(j, i + 1), at(j + 1, i)});
      }
  }

  const Mesh& mesh_;
  int k_;
  TransferVertices& out_;
  std::unordered_map<std::uint64_t, std::uint32_t> edges_;  ///< first vertex on an edge, from its smaller end
};

template <typename T>
void reorder(std::vector<T>& values, const std::vector<std::uint32_t>& order) {
  std::vector<T> result;
  result.reserve(order.size());
  for (const std::uint32_t i : order) result.push_back(values[i]);
  values = std::move(result);
}

}  // namespace

TransferVertices::TransferVertices(const Mesh& mesh, int parts) : parts_(parts) {
  OPALINE_CHECK(parts >= 1);
  Cutter(mesh, parts, *this);
  std::vector<std::uint32_t> order;
  for (const MortonKey& key : morton_sorted(positions)) order.push_back(key.index);
  renumber(order);
}

void TransferVertices::renumber(const std::vector<std::uint32_t>& order) {
  std::vector<std::uint32_t> place(positions.size(), none);
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = static_cast<std::uint32_t>(i);
  reorder(positions, order);
  reorder(normals, order);
  for (glm::uvec3& t : triangles)
    for (int i = 0; i < 3; ++i) t[i] = t[i] == none ? none : place[t[i]];
}

std::vector<std::uint32_t> TransferVertices::keep_only(const Mesh& mesh,
                                                       const std::vector<std::pair<std::uint32_t, glm::vec3>>& points) {
  std::vector<bool> seen(triangles.size());
  for (const auto& [triangle, position] : points) {
    glm::vec3 weight;
    seen[part_at(mesh, triangle, position, weight)] = true;
  }
  std::vector<bool> used(size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (!seen[t]) triangles[t] = glm::uvec3(none);
    for (int i = 0; seen[t] && i < 3; ++i) used[triangles[t][i]] = true;
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t v = 0; v < used.size(); ++v)
    if (used[v]) order.push_back(v);
  renumber(order);
  return order;
}

std::size_t TransferVertices::part_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position,
                                      glm::vec3& weight) const {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::dvec3 a(mesh.positions[t.x]), ab = glm::dvec3(mesh.positions[t.y]) - a,
                                           ac = glm::dvec3(mesh.positions[t.z]) - a;
  const glm::dvec3 n = glm::cross(ab, ac), d = glm::dvec3(position) - a;
  const double area2 = glm::dot(n, n);
  const double v = std::clamp(glm::dot(glm::cross(d, ac), n) / area2, 0.0, 1.0),
               w = std::clamp(glm::dot(glm::cross(ab, d), n) / area2, 0.0, 1 - v);
  const int k = parts_, i = std::min(static_cast<int>(w * k), k - 1), j = std::min(static_cast<int>(v * k), k - 1 - i);
  const double fv = v * k - j, fw = w * k - i;
  const bool turned = fv + fw > 1 && i + j + 1 < k;
  const glm::dvec3 exact = turned ? glm::dvec3(fv + fw - 1, 1 - fv, 1 - fw) : glm::dvec3(1 - fv - fw, fv, fw);
  weight = glm::vec3(exact);
  const int part = i * (2 * k - i) + 2 * j + (turned ? 1 : 0);
  return static_cast<std::size_t>(triangle) * static_cast<std::size_t>(k * k) + static_cast<std::size_t>(part);
}

TransferVertices::Place TransferVertices::at(const Mesh& mesh, std::uint32_t triangle,
                                             const glm::vec3& position) const {
  Place place;
  place.corner = triangles[part_at(mesh, triangle, position, place.weight)];
  return place;
}

std::vector<double> vertex_areas(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles) {
  std::vector<double> areas(positions.size(), 0.0);
  for (const glm::uvec3& t : triangles) {
    const glm::dvec3 a(positions[t.x]), b(positions[t.y]), c(positions[t.z]);
    for (int i = 0; i < 3; ++i) areas[t[i]] += glm::length(glm::cross(b - a, c - a)) / 6;
  }
  return areas;
}

}  // namespace opaline
