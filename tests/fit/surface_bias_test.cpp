// The shape that a fit reports of an object, and the measured errors it looks up for it.
#include "fit/surface_bias.h"
#include "tests/support/fit_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using ::testing::HasSubstr;

TEST(SurfaceBias, FindsTheRadiusAndTheLightOfASphere) {
  Scene scene = test::sphere_scene("skin1", 40, 5000);
  EXPECT_NEAR(surface_shape(scene, 0).radius_mm, 10, 0.5);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  // Over the disk that is seen, the mean of asin(rho) is pi/4.
  EXPECT_NEAR(surface_shape(scene, 0).incidence_deg, 45, 1.5);
  scene.objects[0].mesh = make_slab({10, 10, 5}, 200);
  EXPECT_FALSE(std::isfinite(surface_shape(scene, 0).radius_mm));
  EXPECT_NEAR(surface_shape(scene, 0).incidence_deg, 0, 1e-3);
}

/// Pixels at the two ends of the film are no neighbours: against pairs by their columns, on a surface that bends
/// differently from place to place.
TEST(SurfaceBias, TakesTheCurvatureOfNeighboursAlone) {
  Scene scene = test::sphere_scene("skin1", 2, 500);
  scene.objects[0].mesh = make_torus(4, 2, 4000);
  scene.camera.position = {3.2, 0.3, 60};
  scene.camera.look_at = {3.2, 0.3, 0};
  scene.camera.height = 1;
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  ASSERT_EQ(view.points.size(), 4u);
  std::vector<double> curvature;
  for (const VisiblePoint& a : view.points)
    for (const VisiblePoint& b : view.points) {
      const int dx = std::abs(static_cast<int>(a.pixel % 2) - static_cast<int>(b.pixel % 2)),
                dy = std::abs(static_cast<int>(a.pixel / 2) - static_cast<int>(b.pixel / 2));
      if (a.pixel < b.pixel && dx + dy == 1)
        curvature.push_back(
            static_cast<double>(glm::length(a.normal - b.normal) / glm::length(a.position - b.position)));
    }
  ASSERT_EQ(curvature.size(), 4u);
  std::sort(curvature.begin(), curvature.end());
  EXPECT_NEAR(surface_shape(scene, 0).radius_mm * curvature[2], 1, 1e-5);
}

TEST(SurfaceBias, AnEvenSkyFallsFromFortyFiveDegreesOnAverage) {
  Scene scene = test::sphere_scene("skin1", 8, 500);
  Image sky(2, 1, {"R", "G", "B"});
  for (float& v : sky.data) v = 1;
  scene.lights = {EnvironmentLight{"", std::make_shared<const Image>(sky), Rgb(1)}};
  EXPECT_EQ(surface_shape(scene, 0).incidence_deg, 45);
}

Material material(double sigma_a, double sigma_s_prime) {
  Material m;
  m.sigma_a = Rgb(sigma_a), m.sigma_s_prime = Rgb(sigma_s_prime), m.eta = 1.4;
  return m;
}

/// What came out of the measured fits leads back to their errors: radius 10 and 20 mean free paths, alpha' .9.
TEST(SurfaceBias, LooksUpTheErrorsBehindAResult) {
  const SurfaceBias ten = surface_bias({10, 50}, material(.1 * (1 - .62), .9 * (1 - .38)));
  EXPECT_TRUE(ten.side_light);
  EXPECT_NEAR(ten.radius_mfp[0], 10, 0.05);
  EXPECT_NEAR(ten.sigma_a[0], -.62, 2e-3);
  EXPECT_NEAR(ten.sigma_s_prime[0], -.38, 2e-3);
  EXPECT_THAT(ten.note, HasSubstr("lit obliquely"));
  // A beam: the truth is sigma_a .1, sigma_s' .9; the law says .77 l_d/R.
  const double expected = -.77 / std::sqrt(3 * .1) / 20;
  const SurfaceBias beam = surface_bias({20, 1}, material(.1 * (1 + expected), .9));
  EXPECT_NEAR(beam.sigma_a[2], expected, 1e-4);
  EXPECT_EQ(beam.sigma_s_prime[2], 0);
}

TEST(SurfaceBias, SaysNothingOfWhatIsFlatAndStraight) {
  const double flat = std::numeric_limits<double>::infinity();
  EXPECT_EQ(surface_bias({flat, 3}, material(.1, .9)).note, "");
  EXPECT_THAT(surface_bias({flat, 45}, material(.1, .9)).note, HasSubstr("not known"));
  EXPECT_EQ(surface_bias({flat, 45}, material(.1, .9)).sigma_a[0], 0);
  EXPECT_EQ(surface_bias({flat, 3}, material(0, .9)).sigma_a[0], 0) << "not 0/0";
  for (const double a : {1e-6, .5, 20.0})
    EXPECT_TRUE(std::isfinite(surface_bias({3, 50}, material(a, .9)).sigma_a[1])) << a;
}

}  // namespace
}  // namespace opaline
