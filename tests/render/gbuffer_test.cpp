#include "render/visibility/gbuffer.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

namespace opaline {
namespace {

Scene sphere_scene(int triangles = 20000, int width = 64, int height = 64) {
  Scene scene = test::make_scene(make_sphere(10, triangles), test::library_material("marble"), 24);
  scene.film = {width, height};
  return scene;
}

GBuffer view_of(const Scene& scene) { return make_gbuffer(scene, RayScene(scene)); }

/// Where the pixel's ray meets the sphere of radius 10 at the origin: the nearer root.
glm::dvec3 on_sphere(const CameraRay& ray) {
  const double b = glm::dot(ray.origin, ray.direction), c = glm::dot(ray.origin, ray.origin) - 100;
  return ray.origin + (-b - std::sqrt(std::max(b * b - c, 0.0))) * ray.direction;
}

void expect_points_on_the_sphere(const Scene& scene) {
  const GBuffer view = view_of(scene);
  ASSERT_GT(view.points.size(), 500u);
  for (const VisiblePoint& p : view.points) {
    const CameraRay ray = camera_ray(scene.camera, scene.film, p.pixel % 64 + 0.5, p.pixel / 64 + 0.5);
    const glm::dvec3 position(p.position), exact = on_sphere(ray), normal = glm::normalize(exact);
    // On the ray (barycentrics of grazing hits are worth less); on its triangle; and as near the sphere as a
    // facet of 0.4 mm is.
    const double off_ray = glm::length(glm::cross(position - ray.origin, ray.direction));
    EXPECT_LT(off_ray, glm::dot(normal, -ray.direction) > 0.1 ? 1e-5 * 10 : 1e-3);
    const glm::uvec3 t = scene.objects[0].mesh.triangles[p.triangle];
    const glm::dvec3 a(scene.objects[0].mesh.positions[t.x]), b(scene.objects[0].mesh.positions[t.y]),
        c(scene.objects[0].mesh.positions[t.z]);
    EXPECT_LT(std::abs(glm::dot(position - a, glm::normalize(glm::cross(b - a, c - a)))), 1e-5 * 10);
    EXPECT_NEAR(glm::length(position), 10, 3e-3);
    if (glm::dot(normal, -ray.direction) < 0.2) continue;  // at grazing angles facets move the point along the ray
    EXPECT_LT(glm::length(glm::dvec3(p.normal) - normal), 3e-3);
    EXPECT_NEAR(p.cos_o, glm::dot(normal, -ray.direction), 3e-3);
    EXPECT_EQ(p.object, 0);
  }
}

TEST(GBuffer, OrthographicPointsLieOnTheSphere) { expect_points_on_the_sphere(sphere_scene()); }

TEST(GBuffer, PerspectivePointsLieOnTheSphere) {
  Scene scene = sphere_scene();
  scene.camera.type = Camera::Type::perspective;
  scene.camera.position = {20, 30, 10}, scene.camera.fov_y_deg = 40;
  expect_points_on_the_sphere(scene);
}

TEST(GBuffer, AFinerMeshPutsThemNearer) {
  const auto worst = [](int triangles) {
    double depth = 0;
    for (const VisiblePoint& p : view_of(sphere_scene(triangles)).points)
      depth = std::max(depth, 10 - static_cast<double>(glm::length(p.position)));
    return depth;
  };
  EXPECT_GT(worst(2000), 5 * worst(20000));  // the sagitta of a facet falls as 1 / triangles
}

/// Pixels whose centre is within `radius` pixels of the film's centre.
std::size_t pixels_in_disk(const Film& film, double radius) {
  std::size_t count = 0;
  for (int y = 0; y < film.height; ++y)
    for (int x = 0; x < film.width; ++x)
      count += std::hypot(x + 0.5 - film.width / 2.0, y + 0.5 - film.height / 2.0) < radius;
  return count;
}

void expect_silhouette(const Scene& scene, double radius) {
  const GBuffer view = view_of(scene);
  // The polyhedron's outline is inside the sphere's by at most 2e-4 of the radius.
  EXPECT_LE(view.points.size(), pixels_in_disk(scene.film, radius + 1e-3));
  EXPECT_GE(view.points.size(), pixels_in_disk(scene.film, radius * (1 - 3e-4)));
  const std::uint64_t all =
      static_cast<std::uint64_t>(scene.film.width) * static_cast<std::uint64_t>(scene.film.height);
  EXPECT_EQ(view.counters.done.at("camera_rays"), all);
  EXPECT_EQ(view.counters.skipped.at("pixels_off_object"), all - view.points.size());
}

TEST(GBuffer, TheOrthographicSilhouetteHasItsRadius) {
  // 24 mm over 201 pixels of height, whatever the width.
  expect_silhouette(sphere_scene(20000, 301, 201), 10.0 / 24 * 201);
  expect_silhouette(sphere_scene(20000, 201, 201), 10.0 / 24 * 201);
}

TEST(GBuffer, ThePerspectiveSilhouetteHasItsRadius) {
  // A sphere of radius R at distance d fills the angle asin(R / d) about its centre.
  Scene scene = sphere_scene(20000, 301, 201);
  scene.camera.type = Camera::Type::perspective;
  scene.camera.position = {0, 0, 35}, scene.camera.fov_y_deg = 40;
  expect_silhouette(scene, std::tan(std::asin(10.0 / 35)) / std::tan(20 * pi / 180) * 100.5);
}

TEST(CameraRay, CornersOfAPerspectiveFilm) {
  Camera camera;
  camera.position = {0, 0, 60}, camera.fov_y_deg = 90;
  const Film film{200, 100};
  const auto tangents = [&](double x, double y) {
    const glm::dvec3 d = camera_ray(camera, film, x, y).direction;
    EXPECT_NEAR(glm::length(d), 1, 1e-12);
    return glm::dvec2(d.x / -d.z, d.y / -d.z);
  };
  EXPECT_LT(glm::length(tangents(100, 50)), 1e-12);
  EXPECT_LT(glm::length(tangents(0, 0) - glm::dvec2(-2, 1)), 1e-12) << "top left: x to the left, y up";
  EXPECT_LT(glm::length(tangents(200, 100) - glm::dvec2(2, -1)), 1e-12);
}

TEST(CameraRay, OrthographicRaysAreParallelAndTurnWithUp) {
  Camera camera;
  camera.type = Camera::Type::orthographic;
  camera.position = {0, 0, 60}, camera.up = {1, 0, 0}, camera.height = 10;
  const CameraRay ray = camera_ray(camera, {100, 100}, 100, 0);  // top right; up is +x, so right is -y
  EXPECT_LT(glm::length(ray.direction - glm::dvec3(0, 0, -1)), 1e-12);
  EXPECT_LT(glm::length(ray.origin - glm::dvec3(5, -5, 60)), 1e-12);
}

/// One triangle in the plane z = 0 that fills the view, with one shading normal.
GBuffer triangle_view(const glm::vec3& normal, double camera_z) {
  Mesh mesh;
  mesh.positions = {{-100, -100, 0}, {200, -100, 0}, {-100, 200, 0}};
  mesh.normals.assign(3, normal);
  mesh.triangles = {{0, 1, 2}};
  Scene scene = test::make_scene(mesh, test::library_material("marble"), 10, 4);
  scene.camera.position = {0, 0, camera_z};
  return view_of(scene);
}

TEST(GBuffer, AShadingNormalThatLooksAwayGivesWayToTheFace) {
  const glm::vec3 tilted = glm::normalize(glm::vec3(1, 0, 0.5f)), away = glm::normalize(glm::vec3(1, 0, -0.5f));
  for (const VisiblePoint& p : triangle_view(tilted, 60).points) {
    EXPECT_LT(glm::length(p.normal - tilted), 1e-6f);
    EXPECT_NEAR(p.cos_o, tilted.z, 1e-6f);
  }
  for (const VisiblePoint& p : triangle_view(away, 60).points) {
    EXPECT_EQ(p.normal, glm::vec3(0, 0, 1));
    EXPECT_NEAR(p.cos_o, 1, 1e-6f);
  }
}

TEST(GBuffer, ASurfaceSeenFromBehindKeepsItsOutwardNormal) {
  const GBuffer view = triangle_view({0, 0, 1}, -60);
  ASSERT_EQ(view.points.size(), 16u);
  for (const VisiblePoint& p : view.points) {
    EXPECT_EQ(p.normal, glm::vec3(0, 0, 1));
    EXPECT_NEAR(p.cos_o, 1, 1e-6f);
  }
}

TEST(GBuffer, PointsComeInScanlineOrder) {
  const GBuffer view = view_of(sphere_scene());
  for (std::size_t i = 1; i < view.points.size(); ++i) EXPECT_LT(view.points[i - 1].pixel, view.points[i].pixel);
}

}  // namespace
}  // namespace opaline
