#include "render/scene/texture_coordinates.h"

#include "model/conventions.h"

#include <array>
#include <cmath>
#include <map>

namespace opaline {
namespace {

struct Bounds {
  glm::dvec3 lo{1e300}, hi{-1e300};
  explicit Bounds(const Mesh& mesh) {
    for (const glm::vec3& p : mesh.positions) lo = glm::min(lo, glm::dvec3(p)), hi = glm::max(hi, glm::dvec3(p));
  }
  /// 0 .. 1 across the box; 0.5 where it is flat.
  double share(const glm::dvec3& p, int axis) const {
    const double width = hi[axis] - lo[axis];
    return width > 0 ? (p[axis] - lo[axis]) / width : 0.5;
  }
};

/// u at the poles is any number.
glm::dvec2 projected(const glm::dvec3& p, const Bounds& box, UvProjection projection) {
  if (projection == UvProjection::planar) return {box.share(p, 0), box.share(p, 1)};
  const glm::dvec3 d = p - 0.5 * (box.lo + box.hi);
  const double u = std::atan2(d.x, d.z) / (2 * pi) + 0.5;
  if (projection == UvProjection::cylindrical) return {u, box.share(p, 1)};
  return {u, std::atan2(d.y, std::hypot(d.x, d.z)) / pi + 0.5};
}

bool at_pole(const glm::dvec3& p, const Bounds& box) {
  const glm::dvec3 d = p - 0.5 * (box.lo + box.hi);
  return std::hypot(d.x, d.z) < 1e-6 * glm::length(box.hi - box.lo);
}

/// u of a triangle's corners, each within half a turn of the first that has one; a pole has the mean of the others.
std::array<double, 3> unwrapped(const std::array<double, 3>& u, const std::array<bool, 3>& pole) {
  std::array<double, 3> out = u;
  std::size_t first = 0;
  while (first < 2 && pole[first]) ++first;
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (pole[i]) continue;
    out[i] = u[i] - std::round(u[i] - u[first]);
    sum += out[i], ++count;
  }
  for (std::size_t i = 0; i < 3; ++i)
    if (pole[i]) out[i] = count > 0 ? sum / count : 0.5;
  return out;
}

/// Vertices by where they came from and their u: copies are made where a vertex needs several.
class VertexCopies {
 public:
  explicit VertexCopies(Mesh& mesh) : mesh_(mesh), taken_(mesh.positions.size(), false) {}

  std::uint32_t with_uv(std::uint32_t vertex, const glm::vec2& uv) {
    if (!taken_[vertex]) {
      taken_[vertex] = true;
      mesh_.uvs[vertex] = uv;
    }
    if (mesh_.uvs[vertex] == uv) return vertex;
    const auto [it, is_new] = copies_.try_emplace({vertex, uv.x}, static_cast<std::uint32_t>(mesh_.positions.size()));
    if (is_new) {
      mesh_.positions.push_back(glm::vec3(mesh_.positions[vertex]));
      if (!mesh_.normals.empty()) mesh_.normals.push_back(glm::vec3(mesh_.normals[vertex]));
      mesh_.uvs.push_back(uv);
    }
    return it->second;
  }

 private:
  Mesh& mesh_;
  std::vector<bool> taken_;
  std::map<std::pair<std::uint32_t, float>, std::uint32_t> copies_;
};

}  // namespace

void make_texture_coordinates(Mesh& mesh, UvProjection projection) {
  const Bounds box(mesh);
  mesh.uvs.assign(mesh.positions.size(), glm::vec2(0));
  VertexCopies copies(mesh);
  for (glm::uvec3& triangle : mesh.triangles) {
    std::array<double, 3> u{}, v{};
    std::array<bool, 3> pole{};
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::dvec3 p(mesh.positions[triangle[static_cast<int>(i)]]);
      const glm::dvec2 uv = projected(p, box, projection);
      u[i] = uv.x, v[i] = uv.y;
      pole[i] = projection != UvProjection::planar && at_pole(p, box);
    }
    if (projection != UvProjection::planar) u = unwrapped(u, pole);
    for (std::size_t i = 0; i < 3; ++i)
      triangle[static_cast<int>(i)] = copies.with_uv(triangle[static_cast<int>(i)], glm::vec2(u[i], v[i]));
  }
}

glm::vec2 uv_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 a = mesh.positions[t.x], ab = mesh.positions[t.y] - a, ac = mesh.positions[t.z] - a;
  const glm::vec3 n = glm::cross(ab, ac), d = position - a;
  const float area2 = glm::dot(n, n);
  const float u = glm::dot(glm::cross(d, ac), n) / area2, v = glm::dot(glm::cross(ab, d), n) / area2;
  return (1 - u - v) * mesh.uvs[t.x] + u * mesh.uvs[t.y] + v * mesh.uvs[t.z];
}

}  // namespace opaline
