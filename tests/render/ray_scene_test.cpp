#include "render/visibility/ray_scene.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

#include <limits>
#include <random>

namespace opaline {
namespace {

/// Distance along a ray to a triangle by plane and barycentrics, in double; infinite if it misses.
double hit_distance(const Mesh& mesh, std::size_t triangle, const glm::dvec3& origin, const glm::dvec3& direction) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::dvec3 a(mesh.positions[t.x]), ab = glm::dvec3(mesh.positions[t.y]) - a,
                                           ac = glm::dvec3(mesh.positions[t.z]) - a, n = glm::cross(ab, ac);
  const double distance = glm::dot(a - origin, n) / glm::dot(direction, n);
  const glm::dvec3 d = origin + distance * direction - a;
  const double u = glm::dot(glm::cross(d, ac), n) / glm::dot(n, n), v = glm::dot(glm::cross(ab, d), n) / glm::dot(n, n);
  return distance > 0 && u >= 0 && v >= 0 && u + v <= 1 ? distance : std::numeric_limits<double>::infinity();
}

struct Closest {
  int object = -1;
  double distance = std::numeric_limits<double>::infinity();
};
Closest closest_of_all(const Scene& scene, const glm::dvec3& origin, const glm::dvec3& direction) {
  Closest best;
  for (std::size_t o = 0; o < scene.objects.size(); ++o)
    for (std::size_t t = 0; t < scene.objects[o].mesh.triangles.size(); ++t) {
      const double distance = hit_distance(scene.objects[o].mesh, t, origin, direction);
      if (distance < best.distance) best = {static_cast<int>(o), distance};
    }
  return best;
}

Scene torus_and_sphere() {
  Scene scene = test::make_scene(make_torus(8, 3, 400), test::library_material("marble"), 24);
  scene.objects.push_back({"sphere", make_sphere(3, 200), 0});
  return scene;
}

TEST(RayScene, FindsWhatTestingEveryTriangleFinds) {
  const Scene scene = torus_and_sphere();
  const RayScene rays(scene);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1, 1);
  int hits[3] = {0, 0, 0};
  for (int i = 0; i < 2000; ++i) {
    const glm::dvec3 origin(15 * any(random), 15 * any(random), 15 * any(random));
    const glm::dvec3 direction = glm::normalize(glm::dvec3(any(random), any(random), any(random)) * 10.0 - origin);
    const SurfaceHit hit = rays.closest(glm::vec3(origin), glm::vec3(direction));
    const Closest expected = closest_of_all(scene, origin, direction);
    ASSERT_EQ(hit.object, expected.object) << i;
    ++hits[hit.object + 1];
    if (hit.object < 0) continue;
    const Mesh& mesh = scene.objects[static_cast<std::size_t>(hit.object)].mesh;
    EXPECT_NEAR(hit.distance, expected.distance, 1e-4);
    const SurfacePoint point = surface_point(mesh, hit.triangle, hit.u, hit.v);
    EXPECT_LT(glm::length(glm::dvec3(point.position) - origin - expected.distance * direction), 2e-4);
    EXPECT_TRUE(rays.occluded(glm::vec3(origin), glm::vec3(direction), hit.distance * 1.001f));
    EXPECT_FALSE(rays.occluded(glm::vec3(origin), glm::vec3(direction), hit.distance * 0.999f));
  }
  for (const int count : hits) EXPECT_GT(count, 100) << "the rays must try misses and both objects";
}

TEST(RayScene, NothingIsBetweenASpotAndTheOutsideOnceOffset) {
  Scene scene = test::make_scene(make_sphere(10, 2000), test::library_material("marble"), 24);
  const RayScene rays(scene);
  EXPECT_NEAR(rays.offset(), 1e-5 * std::sqrt(3.0) * 20, 1e-5);
  const Mesh& mesh = scene.objects[0].mesh;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const SurfacePoint p = surface_point(mesh, t, 0.3f, 0.3f);
    const glm::vec3 from = p.position + rays.offset() * p.face_normal;
    EXPECT_FALSE(rays.occluded(from, p.face_normal, std::numeric_limits<float>::infinity())) << t;
    EXPECT_TRUE(rays.occluded(from, -p.face_normal, std::numeric_limits<float>::infinity())) << t;
  }
}

TEST(SurfacePoint, InterpolatesPositionsAndNormals) {
  Mesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}};
  mesh.triangles = {{0, 1, 2}};
  EXPECT_EQ(surface_point(mesh, 0, 0.25f, 0.5f).position, glm::vec3(0.5f, 1, 0));
  EXPECT_EQ(surface_point(mesh, 0, 0.25f, 0.5f).normal, glm::vec3(0, 0, 1)) << "without vertex normals";
  mesh.normals = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_EQ(surface_point(mesh, 0, 0, 0).normal, glm::vec3(1, 0, 0));
  EXPECT_EQ(surface_point(mesh, 0, 1, 0).normal, glm::vec3(0, 1, 0));
  EXPECT_EQ(surface_point(mesh, 0, 0, 1).normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(surface_point(mesh, 0, 0, 1).face_normal, glm::vec3(0, 0, 1));
  mesh.normals = {{1, 0, 0}, {-1, 0, 0}, {1, 0, 0}};
  EXPECT_EQ(surface_point(mesh, 0, 0.5f, 0).normal, glm::vec3(0, 0, 1)) << "opposing normals cancel";
}

}  // namespace
}  // namespace opaline
