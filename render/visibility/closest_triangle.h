// The triangle of a mesh that is nearest to a point (Embree).
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <memory>
#include <vector>

namespace opaline {

struct TrianglePlace {
  std::uint32_t triangle = 0;
  glm::dvec3 weights{1, 0, 0};  ///< barycentrics of the nearest point, in [0, 1], adding up to 1
  double distance = 0;
};

class ClosestTriangle {
 public:
  /// At least one triangle.
  ClosestTriangle(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles);
  ~ClosestTriangle();
  ClosestTriangle(const ClosestTriangle&) = delete;
  ClosestTriangle& operator=(const ClosestTriangle&) = delete;

  /// Of the triangles that face along `normal` (the other side of a thin part may be nearer); of all if none does.
  TrianglePlace find(const glm::vec3& point, const glm::vec3& normal) const;

 private:
  struct Handles;
  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
  std::unique_ptr<Handles> handles_;
};

/// Barycentrics of the point of a triangle that is nearest to p.
glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace opaline
