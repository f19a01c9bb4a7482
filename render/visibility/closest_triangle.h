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
  glm::dvec3 position{0};       ///< that point [mm]
  double distance = 0;          ///< mm
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
  /// Of all triangles, the nearest of which is known to be within that distance [mm]: the closer that is, the shorter
  /// the search. Too small a distance costs a second search, no more.
  TrianglePlace find_within(const glm::vec3& point, double distance) const;

 private:
  struct Handles;
  TrianglePlace find(const glm::vec3& point, const glm::vec3& normal, float radius, bool& found) const;
  std::vector<glm::vec3> positions_;
  std::vector<glm::uvec3> triangles_;
  std::unique_ptr<Handles> handles_;
};

/// Barycentrics of the point of a triangle that is nearest to p; a triangle without area is its longest edge.
/// Ericson 2004, "Real-Time Collision Detection", 5.1.5.
glm::dvec3 closest_on_triangle(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

}  // namespace opaline
