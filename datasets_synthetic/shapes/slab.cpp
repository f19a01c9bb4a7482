#include "datasets_synthetic/shapes/shapes.h"
#include "model/check.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

struct Grid {
  glm::dvec3 lo, hi;
  glm::ivec3 cells;
  /// One formula per axis, so that the faces which meet at an edge agree to the last bit.
  float coordinate(int axis, int i) const {
    const double t = static_cast<double>(i) / cells[axis];
    return static_cast<float>((1 - t) * lo[axis] + t * hi[axis]);
  }
};

/// The face of the box across `axis`, on its low or high side. (u, v, axis) is right-handed.
void add_face(Mesh& mesh, const Grid& grid, int axis, bool high) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const auto first = static_cast<unsigned>(mesh.positions.size());
  glm::vec3 normal(0);
  normal[axis] = high ? 1.0f : -1.0f;
  for (int j = 0; j <= grid.cells[v]; ++j)
    for (int i = 0; i <= grid.cells[u]; ++i) {
      glm::vec3 p;
      p[axis] = grid.coordinate(axis, high ? grid.cells[axis] : 0);
      p[u] = grid.coordinate(u, i);
      p[v] = grid.coordinate(v, j);
      mesh.positions.push_back(p);
      mesh.normals.push_back(normal);
    }
  const unsigned stride = static_cast<unsigned>(grid.cells[u]) + 1;
  for (int j = 0; j < grid.cells[v]; ++j)
    for (int i = 0; i < grid.cells[u]; ++i) {
      const unsigned a = first + j * stride + i, b = a + 1, c = b + stride, d = a + stride;
      mesh.triangles.push_back(high ? glm::uvec3(a, b, c) : glm::uvec3(a, c, b));
      mesh.triangles.push_back(high ? glm::uvec3(a, c, d) : glm::uvec3(a, d, c));
    }
}

/// Cells per axis so that they are nearly square and there are about triangles / 2 in all.
glm::ivec3 cell_counts(glm::dvec3 size, int triangles) {
  const double area = 2 * (size.x * size.y + size.y * size.z + size.z * size.x);
  const auto counts = [&](double edge) { return glm::ivec3(glm::max(glm::round(size / edge), glm::dvec3(1))); };
  double edge = std::sqrt(2 * area / triangles);
  // Axes thinner than a cell still take one: shrink or grow the cell until the count is as asked.
  for (int pass = 0; pass < 8; ++pass) {
    const glm::dvec3 n(counts(edge));
    edge *= std::sqrt(4 * (n.x * n.y + n.y * n.z + n.z * n.x) / triangles);
  }
  return counts(edge);
}

}  // namespace

Mesh make_slab(glm::dvec3 size, int triangles) {
  OPALINE_CHECK(size.x > 0 && size.y > 0 && size.z > 0 && triangles > 0);
  const Grid grid{{-size.x / 2, -size.y / 2, -size.z}, {size.x / 2, size.y / 2, 0}, cell_counts(size, triangles)};
  Mesh mesh;
  for (int axis = 0; axis < 3; ++axis) {
    add_face(mesh, grid, axis, false);
    add_face(mesh, grid, axis, true);
  }
  return mesh;
}

ShapeMaker slab_shape() {
  return {"box, lit face +z with its top at z = 0; size [x, y, z]; triangles (default 20000, at least 12)",
          [](JsonObject& keys) {
            const glm::dvec3 size = keys.vec3("size", Range::positive());
            return make_slab(size, keys.integer_or("triangles", 12, max_shape_triangles, 20000));
          }};
}

}  // namespace opaline
