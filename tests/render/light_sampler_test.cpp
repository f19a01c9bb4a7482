#include "render/irradiance/light_sampler.h"

#include "tests/support/render_fixture.h"

#include <set>

namespace opaline {
namespace {

Scene lit_by(std::vector<Light> lights) {
  Scene scene;
  scene.lights = std::move(lights);
  return scene;
}

std::vector<LightSample> samples(const LightSampler& sampler, const glm::vec3& point, std::uint64_t seed = 1,
                                 std::uint32_t index = 0) {
  std::vector<LightSample> all;
  sampler.for_each(point, seed, index, [&](const LightSample& s) { all.push_back(s); });
  return all;
}

std::shared_ptr<const Image> image(int width, int height, const std::vector<float>& rgb) {
  Image result(width, height, {"R", "G", "B"});
  result.data = rgb;
  return std::make_shared<const Image>(std::move(result));
}

/// Mean and standard error of a sum over one point's samples, over 64 seeds.
struct Estimate {
  double mean = 0, error = 0;
  double z(double exact) const { return (mean - exact) / error; }
};
template <typename Weight>
Estimate estimate(const LightSampler& sampler, Weight weight) {
  constexpr int seeds = 64;
  double sum = 0, squares = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    double value = 0;
    sampler.for_each(glm::vec3(0), static_cast<std::uint64_t>(seed), 0, [&](const LightSample& s) {
      value += static_cast<double>(s.irradiance.r) * weight(glm::dvec3(s.direction));
    });
    sum += value, squares += value * value;
  }
  const double mean = sum / seeds;
  return {mean, std::sqrt(std::max(squares / seeds - mean * mean, 1e-24) / (seeds - 1))};
}

// --- directional -----------------------------------------------------------------------------------

TEST(DirectionalLight, ArrivesFromOneDirectionWithItsIrradiance) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(1, -2, -3));
  const Scene scene = lit_by({DirectionalLight{direction, Rgb(3, 2, 1), 0}});
  const auto all = samples(LightSampler(scene, 64), {5, 6, 7});
  ASSERT_EQ(all.size(), 1u) << "a light without a disk needs one sample";
  EXPECT_LT(glm::length(glm::dvec3(all[0].direction) + direction), 1e-6);
  EXPECT_EQ(all[0].irradiance, glm::vec3(3, 2, 1));
  EXPECT_TRUE(std::isinf(all[0].distance));
}

TEST(DirectionalLight, ADiskLightsAFacingPlaneWithTheStatedIrradiance) {
  const glm::dvec3 direction = glm::normalize(glm::dvec3(0.3, -0.8, 0.2));
  for (const double radius : {0.5, 5.0, 30.0, 60.0}) {
    const Scene scene = lit_by({DirectionalLight{direction, Rgb(3), radius}});
    const auto all = samples(LightSampler(scene, 256), glm::vec3(0));
    ASSERT_EQ(all.size(), 256u);
    double irradiance = 0;
    for (const LightSample& s : all) {
      EXPECT_NEAR(glm::length(s.direction), 1, 1e-6);
      const double cosine = -glm::dot(glm::dvec3(s.direction), direction);
      EXPECT_GE(cosine, std::cos(radius * pi / 180) - 1e-6);
      irradiance += cosine * static_cast<double>(s.irradiance.r);
    }
    EXPECT_NEAR(irradiance, 3, 1e-5) << radius;
  }
}

/// Irradiance of a disk of constant radiance on a plane tilted against its axis, by quadrature.
double disk_on_tilted_plane(double radius_deg, double tilt) {
  const double sine = std::sin(radius_deg * pi / 180), radiance = 1 / (pi * sine * sine);
  const int n = 600;
  double sum = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double theta = radius_deg * pi / 180 * (i + 0.5) / n, phi = 2 * pi * (j + 0.5) / n;
      const double cosine = std::sin(theta) * std::cos(phi) * std::sin(tilt) + std::cos(theta) * std::cos(tilt);
      sum += std::max(cosine, 0.0) * std::sin(theta);
    }
  return radiance * sum * (radius_deg * pi / 180 / n) * (2 * pi / n);
}

TEST(DirectionalLight, TheDiskHasConstantRadiance) {
  // A tilted plane sees the disk set: a wrong density over the disk shows here and not on a facing plane.
  for (const double radius : {5.0, 30.0, 60.0})
    for (const double tilt : {0.5, 1.2, 1.6}) {
      const glm::dvec3 normal(std::sin(tilt), 0, std::cos(tilt));
      const Scene scene = lit_by({DirectionalLight{glm::dvec3(0, 0, -1), Rgb(1), radius}});
      const Estimate e =
          estimate(LightSampler(scene, 256), [&](const glm::dvec3& w) { return std::max(0.0, glm::dot(normal, w)); });
      const double exact = disk_on_tilted_plane(radius, tilt);
      EXPECT_LT(std::abs(e.mean - exact), 4 * e.error + 1e-5) << radius << " " << tilt;
      EXPECT_LT(e.error, 3e-3) << radius << " " << tilt;
    }
}

// --- environment -----------------------------------------------------------------------------------

TEST(EnvironmentLight, UniformRadianceLightsAPlaneWithPiTimesIt) {
  const Scene scene = lit_by({EnvironmentLight{"", image(8, 4, std::vector<float>(8 * 4 * 3, 0.5f)), Rgb(4)}});
  for (const glm::dvec3& normal : {glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0), glm::normalize(glm::dvec3(1, 0.2, -2))}) {
    const Estimate e =
        estimate(LightSampler(scene, 256), [&](const glm::dvec3& w) { return std::max(0.0, glm::dot(normal, w)); });
    EXPECT_LT(std::abs(e.z(2 * pi)), 4) << e.mean;
    EXPECT_LT(e.error, 0.01 * 2 * pi);
  }
}

/// 16 x 8 pixels, black but for one.
EnvironmentLight hot_pixel(int x, int y, float value) {
  std::vector<float> rgb(16 * 8 * 3, 0.0f);
  for (int c = 0; c < 3; ++c) rgb[static_cast<std::size_t>((y * 16 + x) * 3 + c)] = value;
  return {"", image(16, 8, rgb), Rgb(1)};
}

// Bilinear lookup makes a hot pixel a tent two pixels wide in longitude and latitude. With both steps equal its
// integral over the sphere is value * step * int tent(theta) sin(theta) = value * 2 sin(theta_0) (1 - cos(step)).
// Nearly half of it lies outside the pixel itself.
TEST(EnvironmentLight, AHotPixelIntegratesToItsClosedForm) {
  const double step = pi / 8;
  for (const int y : {1, 3, 6}) {
    const Scene scene = lit_by({hot_pixel(5, y, 1e5f)});
    const double exact = 1e5 * 2 * std::sin((y + 0.5) * step) * (1 - std::cos(step));
    const Estimate e = estimate(LightSampler(scene, 256), [](const glm::dvec3&) { return 1.0; });
    EXPECT_LT(std::abs(e.z(exact)), 4) << y << ": " << e.mean << " for " << exact;
    EXPECT_LT(e.error, 0.01 * exact);
  }
}

TEST(EnvironmentLight, PixelsStandWhereThePageSaysTheyDo) {
  std::vector<float> rgb;
  for (int i = 0; i < 8 * 4; ++i) rgb.insert(rgb.end(), {static_cast<float>(i), 0, 0});
  const EnvironmentLight light{"", image(8, 4, rgb), Rgb(2)};
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 8; ++x) {
      // Column 0 starts behind (+z), the middle is -z, to the right it turns to +x; row 0 is up.
      const double phi = ((x + 0.5) / 8 - 0.5) * 2 * pi, theta = (y + 0.5) / 4 * pi;
      const glm::dvec3 w(std::sin(theta) * std::sin(phi), std::cos(theta), -std::sin(theta) * std::cos(phi));
      EXPECT_NEAR(environment_radiance(light, w).r, 2 * (y * 8 + x), 1e-5);
    }
  // Behind, columns 7 and 0 meet: halfway between them, the mean.
  EXPECT_NEAR(environment_radiance(light, {0, std::cos(1.5 / 4 * pi), std::sin(1.5 / 4 * pi)}).r, 2 * (8 + 3.5), 1e-5);
}

TEST(EnvironmentLight, EveryDirectionIsUnitAndABlackOneGivesNone) {
  const Scene scene = lit_by({hot_pixel(0, 0, 7)}), black = lit_by({hot_pixel(0, 0, 0)});
  const auto all = samples(LightSampler(scene, 500), glm::vec3(0));
  EXPECT_GT(all.size(), 300u) << "the rest fell on the dark halves of the neighbours";
  for (const LightSample& s : all) {
    EXPECT_NEAR(glm::length(s.direction), 1, 1e-6);
    EXPECT_TRUE(std::isfinite(s.irradiance.r) && s.irradiance.r > 0);
  }
  EXPECT_TRUE(samples(LightSampler(black, 500), glm::vec3(0)).empty());
}

// --- point and projector ---------------------------------------------------------------------------

TEST(PointLight, FallsWithTheSquareOfTheDistance) {
  const Scene scene = lit_by({PointLight{{1, 2, 3}, Rgb(100, 50, 25)}});
  const LightSampler sampler(scene, 64);
  for (const double d : {0.5, 2.0, 40.0}) {
    const auto all = samples(sampler, glm::vec3(glm::dvec3(1, 2, 3) + d * glm::dvec3(0, 0.6, 0.8)));
    ASSERT_EQ(all.size(), 1u);
    EXPECT_NEAR(all[0].distance, d, 1e-5 * d);
    EXPECT_NEAR(all[0].irradiance.r, 100 / (d * d), 1e-5 * 100 / (d * d));
    EXPECT_NEAR(all[0].irradiance.b, 25 / (d * d), 1e-5 * 25 / (d * d));
    EXPECT_LT(glm::length(all[0].direction - glm::vec3(0, -0.6f, -0.8f)), 1e-5f);
  }
  EXPECT_TRUE(samples(sampler, {1, 2, 3}).empty()) << "the place of the light itself has no direction";
}

TEST(ProjectorLight, ADiskIsAConeOfConstantIntensity) {
  ProjectorLight projector;
  projector.position = {0, 0, 10}, projector.intensity = Rgb(200), projector.disk_radius_deg = 20;
  const Scene scene = lit_by({projector});
  const LightSampler sampler(scene, 64);
  const double edge = 10 * std::tan(20 * pi / 180);
  for (const double phi : {0.0, 1.0, 2.5, 4.0}) {
    const auto at = [&](double r) { return samples(sampler, glm::vec3(r * std::cos(phi), r * std::sin(phi), 0)); };
    ASSERT_EQ(at(0.999 * edge).size(), 1u) << phi;
    EXPECT_NEAR(at(0.999 * edge)[0].irradiance.g, 200 / (100 + 0.998 * edge * edge), 1e-3);
    EXPECT_TRUE(at(1.001 * edge).empty()) << phi;
  }
  EXPECT_TRUE(samples(sampler, {0, 0, 20}).empty()) << "behind the projector";
}

TEST(ProjectorLight, AnImageFillsItsFieldAndStandsUpright) {
  // 4 x 2 pixels: red grows to the right, green upwards.
  std::vector<float> rgb;
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) rgb.insert(rgb.end(), {static_cast<float>(x + 1), y == 0 ? 2.0f : 1.0f, 1.0f});
  ProjectorLight projector;
  projector.position = {0, 0, 10}, projector.intensity = Rgb(100), projector.fov_y_deg = 40;
  projector.image = image(4, 2, rgb);
  const Scene scene = lit_by({projector});
  const LightSampler sampler(scene, 64);
  const double half = 10 * std::tan(20 * pi / 180);  // in y; twice that in x
  const auto at = [&](double x, double y) { return samples(sampler, glm::vec3(x * half, y * half, 0)); };
  for (int y = 0; y < 2; ++y)
    for (int x = 0; x < 4; ++x) {
      const double px = (x + 0.5) - 2, py = y == 0 ? 0.5 : -0.5;  // pixel centres, in half heights
      const auto all = at(px, py);
      ASSERT_EQ(all.size(), 1u);
      const double d2 = half * half * (px * px + py * py) + 100;
      EXPECT_NEAR(all[0].irradiance.r, 100 * (x + 1) / d2, 1e-4);
      EXPECT_NEAR(all[0].irradiance.g, 100 * (y == 0 ? 2 : 1) / d2, 1e-4);
    }
  EXPECT_FALSE(at(1.999, 0.999).empty());
  EXPECT_TRUE(at(2.001, 0).empty());
  EXPECT_TRUE(at(0, 1.001).empty());
}

// --- numbering -------------------------------------------------------------------------------------

TEST(LightSampler, SeedsAreReproducibleAndDiffer) {
  const Scene scene = lit_by({DirectionalLight{{0, 0, -1}, Rgb(1), 20}, hot_pixel(3, 3, 1)});
  const auto first_of = [&](std::uint64_t seed, std::uint32_t index) {
    return samples(LightSampler(scene, 16), glm::vec3(0), seed, index)[0].direction;
  };
  EXPECT_EQ(first_of(5, 2), first_of(5, 2));
  EXPECT_NE(first_of(5, 2), first_of(6, 2));
  EXPECT_NE(first_of(5, 2), first_of(5, 3));
}

TEST(LightSampler, ConsecutiveNumbersFillTheSquareEvenly) {
  // 4 points of 64 samples each share one sequence: 256 points, about one in each of 16 x 16 squares.
  std::set<int> squares;
  for (std::uint32_t i = 0; i < 256; ++i) {
    const auto [u, v] = shifted_r2(11, i);
    ASSERT_GE(std::min(u, v), 0);
    ASSERT_LT(std::max(u, v), 1);
    squares.insert(static_cast<int>(16 * u) * 16 + static_cast<int>(16 * v));
  }
  EXPECT_GT(squares.size(), 200u);  // white noise fills 162
}

// --- one colour ------------------------------------------------------------------------------------

TEST(SingleColour, IsFoundWhereAllLightsShareIt) {
  Rgb colour(0);
  const Scene none = lit_by({});
  EXPECT_TRUE(LightSampler(none, 1).single_colour(colour));
  EXPECT_EQ(colour, Rgb(1));
  const Scene alike = lit_by({DirectionalLight{{0, 0, -1}, Rgb(1, 2, 4), 0}, PointLight{{0, 0, 9}, Rgb(50, 100, 200)}});
  EXPECT_TRUE(LightSampler(alike, 1).single_colour(colour));
  EXPECT_LT(glm::length(colour - Rgb(0.25, 0.5, 1)), 1e-12) << "scaled so that the largest channel is 1";
}

TEST(SingleColour, IsNotFoundWhereTheyDiffer) {
  Rgb colour;
  const Scene differ = lit_by({PointLight{{0, 0, 9}, Rgb(1, 2, 4)}, PointLight{{0, 9, 0}, Rgb(1, 2, 3)}});
  EXPECT_FALSE(LightSampler(differ, 1).single_colour(colour));
}

TEST(SingleColour, ImagesHaveOneIfTheyAreGrey) {
  const auto grey = image(2, 1, {1, 1, 1, 3, 3, 3}), coloured = image(2, 1, {1, 1, 1, 3, 3, 2});
  Image one_channel(2, 1, {"Y"});
  one_channel.data = {0.5f, 1};
  const auto single = std::make_shared<const Image>(one_channel);
  const auto has_one = [](const Light& light) {
    Rgb colour;
    const Scene scene = lit_by({light});
    return LightSampler(scene, 1).single_colour(colour) && glm::length(colour - Rgb(1, 0.5, 0.5)) < 1e-12;
  };
  ProjectorLight projector;
  projector.intensity = Rgb(2, 1, 1);
  EXPECT_TRUE(has_one(projector)) << "a disk";
  for (const auto& [picture, expected] : {std::pair(grey, true), std::pair(single, true), std::pair(coloured, false)}) {
    projector.image = picture;
    EXPECT_EQ(has_one(projector), expected);
    EXPECT_EQ(has_one(EnvironmentLight{"", picture, Rgb(2, 1, 1)}), expected);
  }
}

}  // namespace
}  // namespace opaline
