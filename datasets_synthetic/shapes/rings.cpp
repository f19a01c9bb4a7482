#include "datasets_synthetic/shapes/rings.h"

namespace opaline {
namespace {

float squared_distance(const Mesh& mesh, unsigned a, unsigned b) {
  const glm::vec3 d = mesh.positions[a] - mesh.positions[b];
  return glm::dot(d, d);
}

}  // namespace

unsigned add_ring(Mesh& mesh, int count, const std::function<SurfacePoint(int)>& point) {
  const auto first = static_cast<unsigned>(mesh.positions.size());
  for (int i = 0; i < count; ++i) {
    const SurfacePoint p = point(i);
    mesh.positions.push_back(glm::vec3(p.position));
    mesh.normals.push_back(glm::vec3(p.normal));
  }
  return first;
}

void join_rings(Mesh& mesh, unsigned a, unsigned b, int count) {
  for (int i = 0; i < count; ++i) {
    const unsigned j = (i + 1) % count;
    const unsigned a0 = a + i, a1 = a + j, b0 = b + i, b1 = b + j;
    // Equal diagonals (up to rounding) are all cut the same way.
    if (squared_distance(mesh, a1, b0) < 0.999f * squared_distance(mesh, a0, b1)) {
      mesh.triangles.emplace_back(a0, b0, a1);
      mesh.triangles.emplace_back(a1, b0, b1);
    } else {
      mesh.triangles.emplace_back(a0, b0, b1);
      mesh.triangles.emplace_back(a0, b1, a1);
    }
  }
}

void join_pole(Mesh& mesh, unsigned ring, unsigned pole, int count, bool pole_is_b) {
  for (int i = 0; i < count; ++i) {
    const unsigned r0 = ring + i, r1 = ring + (i + 1) % count;
    mesh.triangles.push_back(pole_is_b ? glm::uvec3(r1, r0, pole) : glm::uvec3(r0, r1, pole));
  }
}

}  // namespace opaline
