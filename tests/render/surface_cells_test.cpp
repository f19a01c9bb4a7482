#include "render/irradiance/surface_cells.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

#include <numeric>

namespace opaline {
namespace {

double total_area(const SurfaceCells& cells) {
  return std::accumulate(cells.begin(), cells.end(), 0.0,
                         [](double sum, const SurfaceCell& c) { return sum + static_cast<double>(cell_area(c)); });
}

/// Smallest barycentric coordinate of p in its triangle, and its distance from the triangle's plane.
std::pair<double, double> inside(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& p) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::dvec3 a(mesh.positions[t.x]), ab = glm::dvec3(mesh.positions[t.y]) - a,
                                           ac = glm::dvec3(mesh.positions[t.z]) - a, n = glm::cross(ab, ac),
                                           d = glm::dvec3(p) - a;
  const double u = glm::dot(glm::cross(d, ac), n) / glm::dot(n, n), v = glm::dot(glm::cross(ab, d), n) / glm::dot(n, n);
  return {std::min({u, v, 1 - u - v}), std::abs(glm::dot(d, n)) / glm::length(n)};
}

class SurfaceCellsOfShapes : public testing::TestWithParam<int> {
 protected:
  Mesh mesh() const {
    if (GetParam() == 0) return make_sphere(10, 500);
    if (GetParam() == 1) return make_slab({20, 10, 1}, 400);
    return make_torus(8, 3, 600);
  }
};

TEST_P(SurfaceCellsOfShapes, CoverTheMeshOnce) {
  const Mesh m = mesh();
  const SurfaceCells cells = make_surface_cells(m, 5000);
  EXPECT_EQ(cells.size(), 5000u);
  EXPECT_NEAR(total_area(cells), surface_area(m), 1e-5 * surface_area(m));
  std::vector<double> per_triangle(m.triangles.size(), 0.0);
  for (const SurfaceCell& c : cells) per_triangle[c.triangle] += static_cast<double>(cell_area(c));
  for (std::size_t t = 0; t < per_triangle.size(); ++t) {
    const glm::uvec3 i = m.triangles[t];
    const SurfaceCell whole{m.positions[i.x], m.positions[i.y], m.positions[i.z], 0};
    EXPECT_NEAR(per_triangle[t], cell_area(whole), 1e-4f * cell_area(whole)) << t;
  }
}

TEST_P(SurfaceCellsOfShapes, LieInTheirTrianglesAndFaceTheSameWay) {
  const Mesh m = mesh();
  for (const SurfaceCell& c : make_surface_cells(m, 3000)) {
    for (const glm::vec3& p : {c.a, c.b, c.c}) {
      const auto [smallest, off_plane] = inside(m, c.triangle, p);
      EXPECT_GT(smallest, -1e-5);
      EXPECT_LT(off_plane, 1e-5);
    }
    const glm::uvec3 t = m.triangles[c.triangle];
    const glm::vec3 n = glm::cross(m.positions[t.y] - m.positions[t.x], m.positions[t.z] - m.positions[t.x]);
    EXPECT_GT(glm::dot(glm::cross(c.b - c.a, c.c - c.a), n), 0);
  }
}

// Halving the largest first ends within a factor of 2 if the mesh starts there (measured: 2.00).
TEST_P(SurfaceCellsOfShapes, HaveLikeAreas) {
  for (const std::size_t count : {2000u, 3000u, 5000u}) {
    float lo = 1e30f, hi = 0;
    for (const SurfaceCell& c : make_surface_cells(mesh(), count))
      lo = std::min(lo, cell_area(c)), hi = std::max(hi, cell_area(c));
    EXPECT_LT(hi / lo, 2.1f) << count;
  }
}

TEST_P(SurfaceCellsOfShapes, StayFat) {
  // Bisecting the longest edge keeps angles: longest edge squared over area, 2.9 to 4.5 in the meshes, 6.9 here.
  for (const SurfaceCell& c : make_surface_cells(mesh(), 5000)) {
    const float edge = std::max({glm::length(c.b - c.a), glm::length(c.c - c.b), glm::length(c.a - c.c)});
    EXPECT_LT(edge * edge / cell_area(c), 8);
  }
}

TEST_P(SurfaceCellsOfShapes, AreTheSameEveryTime) {
  const Mesh m = mesh();
  const SurfaceCells a = make_surface_cells(m, 3001), b = make_surface_cells(m, 3001);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].a, b[i].a);
    EXPECT_EQ(a[i].b, b[i].b);
    EXPECT_EQ(a[i].c, b[i].c);
    EXPECT_EQ(a[i].triangle, b[i].triangle);
  }
}

INSTANTIATE_TEST_SUITE_P(SphereSlabTorus, SurfaceCellsOfShapes, testing::Values(0, 1, 2));

TEST(SurfaceCells, AMeshWithMoreTrianglesThanAskedKeepsOneCellEach) {
  const Mesh mesh = make_sphere(10, 500);
  const SurfaceCells cells = make_surface_cells(mesh, 10);
  ASSERT_EQ(cells.size(), mesh.triangles.size());
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(cells[i].triangle, i);
}

TEST(SurfaceCells, ObjectsShareTheTotalByArea) {
  Scene scene = test::make_scene(make_sphere(10, 80), test::library_material("marble"), 22);
  scene.objects.push_back({"small", make_sphere(5, 80), 0});
  scene.objects.push_back({"tiny", make_sphere(0.01, 80), 0});
  const std::vector<SurfaceCells> cells = make_surface_cells(scene, 5000);
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_NEAR(static_cast<double>(cells[0].size()), 4000, 10);
  EXPECT_NEAR(static_cast<double>(cells[1].size()), 1000, 10);
  EXPECT_EQ(cells[2].size(), 80u) << "at least a cell for every triangle";
}

TEST(SurfaceCells, QuartersAreSimilarAndFillTheCell) {
  const SurfaceCell cell{{0, 0, 0}, {3, 0, 1}, {1, 2, 0}, 7};
  SurfaceCell quarters[4];
  split_in_four(cell, quarters);
  glm::vec3 centroid(0);
  const glm::vec3 normal = glm::normalize(glm::cross(cell.b - cell.a, cell.c - cell.a));
  for (const SurfaceCell& q : quarters) {
    EXPECT_NEAR(cell_area(q), cell_area(cell) / 4, 1e-6f);
    EXPECT_NEAR(glm::dot(glm::normalize(glm::cross(q.b - q.a, q.c - q.a)), normal), 1, 1e-6f);
    EXPECT_EQ(q.triangle, 7u);
    centroid += cell_centroid(q) / 4.0f;
  }
  EXPECT_LT(glm::length(centroid - cell_centroid(cell)), 1e-6f);
}

}  // namespace
}  // namespace opaline
