#include "datasets_synthetic/shapes/shapes.h"
#include "model/check.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {
namespace {

using Corners = std::array<int, 3>;

constexpr std::array<Corners, 20> faces{{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                         {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                         {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                         {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}}};

glm::dvec3 corner(int i) {
  const double phi = (1 + std::sqrt(5.0)) / 2;
  const glm::dvec3 table[12] = {{-1, phi, 0},  {1, phi, 0},  {-1, -phi, 0}, {1, -phi, 0}, {0, -1, phi},  {0, 1, phi},
                                {0, -1, -phi}, {0, 1, -phi}, {phi, 0, -1},  {phi, 0, 1},  {-phi, 0, -1}, {-phi, 0, 1}};
  return glm::normalize(table[i]);
}

/// Numbers the vertices of the divided icosahedron so that faces share those on their edges.
class Numbering {
 public:
  explicit Numbering(int frequency) : f_(frequency) {
    for (auto& row : edge_) row.fill(-1);
    int count = 0;
    for (const Corners& face : faces)
      for (int s = 0; s < 3; ++s) {
        int& slot = edge_slot(face[s], face[(s + 1) % 3]);
        if (slot < 0) slot = count++;
      }
  }
  int vertex_count() const { return 10 * f_ * f_ + 2; }
  /// Vertex of face `face` with integer barycentric weights w that sum to the frequency.
  int index(int face, const Corners& w) {
    const Corners& c = faces[face];
    for (int s = 0; s < 3; ++s)
      if (w[s] == f_) return c[s];
    for (int s = 0; s < 3; ++s)
      if (w[s] == 0) return on_edge(c[(s + 1) % 3], c[(s + 2) % 3], w[(s + 2) % 3]);
    const int row = w[1] - 1, inner = (f_ - 1) * (f_ - 2) / 2;  // rows of f - 2, f - 3, ... vertices
    return 12 + 30 * (f_ - 1) + face * inner + row * (f_ - 2) - row * (row - 1) / 2 + w[2] - 1;
  }

 private:
  int& edge_slot(int a, int b) { return edge_[std::min(a, b)][std::max(a, b)]; }
  /// `steps` from a towards b.
  int on_edge(int a, int b, int steps) { return 12 + edge_slot(a, b) * (f_ - 1) + (a < b ? steps : f_ - steps) - 1; }
  int f_;
  std::array<std::array<int, 12>, 12> edge_;
};

/// Sine weights make every edge an evenly divided great arc and even out the areas inside.
glm::dvec3 direction(int face, const Corners& w, int frequency) {
  const double arc = std::acos(1 / std::sqrt(5.0));  // between neighbouring corners of an icosahedron
  glm::dvec3 sum(0);
  for (int s = 0; s < 3; ++s) sum += std::sin(arc * w[s] / frequency) * corner(faces[face][s]);
  return glm::normalize(sum);
}

void add_face_triangles(Mesh& mesh, Numbering& numbering, int face, int f) {
  const auto at = [&](int i, int j) { return static_cast<unsigned>(numbering.index(face, {f - i - j, i, j})); };
  for (int i = 0; i < f; ++i)
    for (int j = 0; i + j < f; ++j) {
      mesh.triangles.emplace_back(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j + 2 <= f) mesh.triangles.emplace_back(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
}

void place_face_vertices(Mesh& mesh, Numbering& numbering, int face, int f, double radius) {
  for (int i = 0; i <= f; ++i)
    for (int j = 0; i + j <= f; ++j) {
      const Corners w{f - i - j, i, j};
      const glm::dvec3 n = direction(face, w, f);
      const int v = numbering.index(face, w);
      mesh.positions[v] = glm::vec3(radius * n);
      mesh.normals[v] = glm::vec3(n);
    }
}

}  // namespace

Mesh make_sphere(double radius, int triangles) {
  OPALINE_CHECK(radius > 0 && triangles > 0);
  const int f = std::max(1, static_cast<int>(std::lround(std::sqrt(triangles / 20.0))));
  Numbering numbering(f);
  Mesh mesh;
  mesh.positions.resize(numbering.vertex_count());
  mesh.normals.resize(numbering.vertex_count());
  for (int face = 0; face < 20; ++face) {
    place_face_vertices(mesh, numbering, face, f, radius);
    add_face_triangles(mesh, numbering, face, f);
  }
  return mesh;
}

ShapeMaker sphere_shape() {
  return {"sphere centred at the origin; radius; triangles (default 20000, at least 20)", [](JsonObject& keys) {
            const double radius = keys.number("radius", Range::positive());
            return make_sphere(radius, keys.integer_or("triangles", 20, max_shape_triangles, 20000));
          }};
}

}  // namespace opaline
