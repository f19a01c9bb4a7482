// Shadow maps against shadow rays.
#include "render/gl/shadow_irradiance.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using testing::HasSubstr;

/// A ball above a torus: each throws shadows on the other and the torus on itself.
Scene ball_over_torus() {
  Scene scene = test::make_scene(make_torus(6, 2, 4000), test::library_material("marble"), 18, 64);
  scene.camera = {Camera::Type::perspective, {5, -30, 40}, {0, 0, 0}, {0, 1, 0}, 22, 0};
  Mesh ball = make_sphere(2, 500);
  for (glm::vec3& p : ball.positions) p += glm::vec3(5, 2, 5);
  scene.materials.push_back(test::library_material("wholemilk"));
  scene.materials[1].eta = 1.5;
  scene.objects.push_back({"ball", ball, 1});
  return scene;
}

ProjectorLight projector(bool image) {
  ProjectorLight light;
  light.position = {4, 5, 40}, light.fov_y_deg = 15, light.disk_radius_deg = 14, light.intensity = Rgb(1600, 900, 400);
  if (!image) return light;
  Image picture(5, 3, {"R", "G", "B"});
  for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = 0.2f + 0.1f * static_cast<float>(i % 7);
  light.image = std::make_shared<const Image>(picture);
  return light;
}

/// Share of the values that differ by more than 1 % of the largest, and RMS of the others over the largest.
std::pair<double, double> difference(const ViewIrradiance& a, const ViewIrradiance& b) {
  EXPECT_EQ(a.channels, b.channels);
  EXPECT_EQ(a.colour, b.colour);
  EXPECT_EQ(a.values.size(), b.values.size());
  const double largest = static_cast<double>(*std::max_element(b.values.begin(), b.values.end()));
  double outliers = 0, squares = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double d = std::abs(static_cast<double>(a.values[i] - b.values[i])) / largest;
    d > 0.01 ? ++outliers : squares += d * d;
  }
  const double n = static_cast<double>(a.values.size());
  return {outliers / n, std::sqrt(squares / n)};
}

class ShadowMaps : public testing::TestWithParam<std::string> {
 protected:
  std::vector<Light> lights() const {
    const DirectionalLight directional{glm::normalize(glm::dvec3(0.5, -0.3, -1)), Rgb(2), 0};
    const PointLight point{{-10, 15, 25}, Rgb(900, 500, 100)};
    if (GetParam() == "directional") return {directional};
    if (GetParam() == "point") return {point};
    if (GetParam() == "disk") return {projector(false)};
    if (GetParam() == "image") return {projector(true)};
    return {directional, point, projector(true)};
  }
};

TEST_P(ShadowMaps, AgreeWithShadowRaysBesideTheEdges) {
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  Scene scene = ball_over_torus();
  scene.lights = lights();
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  Counters counters;
  const ViewIrradiance mapped = gl::ShadowIrradiance(*context, scene, 1024).at(view, counters),
                       traced = view_irradiance(scene, rays, view, {}, false, counters),
                       unshadowed = view_irradiance(scene, rays, view, {}, true, counters);
  EXPECT_EQ(counters.done.at("shadow_maps"), scene.lights.size());
  const auto [outliers, rms] = difference(mapped, traced);
  EXPECT_LT(outliers, 0.01);
  EXPECT_LT(rms, 3e-4);
  EXPECT_GT(difference(unshadowed, traced).first, 0.02) << "there are shadows to get right";
}

INSTANTIATE_TEST_SUITE_P(Lights, ShadowMaps, testing::Values("directional", "point", "disk", "image", "three"),
                         [](const auto& row) { return row.param; });

TEST(ShadowIrradiance, NeedsNoMapWhereNothingIsInShadow) {
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  const Scene scene = test::make_scene(make_sphere(10, 1000), test::library_material("skin1"), 22, 40);
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  Counters counters;
  const ViewIrradiance mapped = gl::ShadowIrradiance(*context, scene, 1024).at(view, counters),
                       traced = view_irradiance(scene, rays, view, {}, false, counters);
  EXPECT_EQ(counters.done.count("shadow_maps"), 0u);
  EXPECT_EQ(counters.skipped.at("shadow_maps_nothing_in_shadow"), 1u);
  EXPECT_EQ(difference(mapped, traced).first, 0);
  EXPECT_LT(difference(mapped, traced).second, 1e-5);
}

TEST(ShadowIrradiance, RefusesLightsWithExtentAndThoseTooNear) {
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  Scene scene = test::make_scene(make_sphere(10, 1000), test::library_material("skin1"), 22, 8);
  const auto message = [&] { return test::message_of([&] { gl::ShadowIrradiance(*context, scene, 64); }); };
  scene.lights.push_back(DirectionalLight{{0, 0, -1}, Rgb(1), 3});
  EXPECT_THAT(message(), HasSubstr("/lights/1: a shadow map needs a light without extent; use irradiance=traced"));
  scene.lights[1] = PointLight{{0, 0, 11}, Rgb(1)};
  EXPECT_THAT(message(), HasSubstr("/lights/1: the light is too near"));
}

}  // namespace
}  // namespace opaline
