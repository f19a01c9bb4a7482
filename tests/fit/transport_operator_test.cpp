// The operator's pictures against the sum over every cell, and its coefficients against differences.
#include "fit/transport_operator.h"
#include "tests/support/fit_fixture.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <functional>

namespace opaline {
namespace {

std::shared_ptr<const Image> coloured_sky() {
  auto image = std::make_shared<Image>(16, 8, std::vector<std::string>{"R", "G", "B"});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x)
      for (int c = 0; c < 3; ++c) image->at(x, y, c) = 0.2f + static_cast<float>((x + 3 * y + 5 * c) % 7);
  return image;
}

std::vector<Light> two_colours() {
  return {DirectionalLight{glm::normalize(glm::dvec3(-1, 0, -0.4)), Rgb(2, 0.4, 0.1), 0},
          DirectionalLight{glm::normalize(glm::dvec3(1, 0.2, -0.4)), Rgb(0.1, 0.5, 2), 0}};
}

Scene slab_with_beam(const std::string& material) {
  Scene scene = test::make_scene(make_slab({20, 20, 8}, 1500), test::library_material(material), 8, 20);
  ProjectorLight beam;
  beam.position = {0, 0, 40}, beam.disk_radius_deg = 2, beam.intensity = Rgb(1600, 1500, 1400);
  scene.lights = {beam};
  return scene;
}

Scene bust_scene(const std::string& material) {
  return test::make_scene(make_bust(30, 8000), test::library_material(material), 31, 20);
}

struct Case {
  std::string name;
  std::function<Scene()> scene;
  int light_channels;
};

Scene with_lights(Scene scene, std::vector<Light> lights) {
  scene.lights = std::move(lights);
  return scene;
}

std::vector<Case> cases() {
  return {{"sphere_skin1", [] { return test::sphere_scene("skin1", 20); }, 1},
          {"sphere_wholemilk", [] { return test::sphere_scene("wholemilk", 20); }, 1},
          {"sphere_marble_two_lights", [] { return with_lights(test::sphere_scene("marble", 20), two_colours()); }, 3},
          {"sphere_skin1_sky",
           [] {
             return with_lights(test::sphere_scene("skin1", 20), {EnvironmentLight{"sky", coloured_sky(), Rgb(1)}});
           },
           3},
          {"slab_marble_beam", [] { return slab_with_beam("marble"); }, 1},
          {"slab_wholemilk_beam", [] { return slab_with_beam("wholemilk"); }, 1},
          {"bust_skin1", [] { return bust_scene("skin1"); }, 1}};
}

class AgainstEveryCell : public ::testing::TestWithParam<Case> {};

TEST_P(AgainstEveryCell, PicturesAgree) {
  const Scene scene = GetParam().scene();
  const OperatorSettings settings = test::small_operator();
  const Image truth = test::picture_of(scene, settings, "brute_force");
  const Material& material = scene.materials.front();
  for (const EtaNodes& etas : {test::free_eta(), EtaNodes(material.eta)}) {
    const TransportOperator op = build_operator(scene, 0, etas, settings);
    ASSERT_GT(op.rows(), 200u);
    EXPECT_EQ(op.light_channels, GetParam().light_channels);
    EXPECT_EQ(op.columns(), static_cast<std::size_t>(op.radial.size() * etas.size()));
    EXPECT_EQ(op.counters.done.at("rows"), op.rows());
    const Image image = operator_image(op, test::dipole(), material);
    EXPECT_LT(test::relative_rms(op, image, truth), 1e-4) << etas.size() << " eta nodes";
    for (std::size_t i = 0; i < image.pixel_count(); ++i)
      EXPECT_EQ(image.data[4 * i + 3], truth.data[4 * i + 3]) << "alpha of pixel " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(TransportOperator, AgainstEveryCell, ::testing::ValuesIn(cases()),
                         [](const auto& parameter) { return parameter.param.name; });

TEST(TransportOperator, ServesAnyEtaOfItsRange) {
  Scene scene = test::sphere_scene("marble", 16);
  const OperatorSettings settings = test::small_operator();
  const TransportOperator op = build_operator(scene, 0, test::free_eta(), settings);
  for (const double eta : {1.06, 1.2, 1.7, 1.98}) {
    scene.materials.front().eta = eta;
    const Image truth = test::picture_of(scene, settings, "brute_force");
    EXPECT_LT(test::relative_rms(op, operator_image(op, test::dipole(), scene.materials.front()), truth), 1e-4) << eta;
  }
}

TEST(TransportOperator, CoefficientsHaveTheirDerivatives) {
  Scene scene = test::sphere_scene("skin1", 6, 500);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(2, 1, 0.5), 0}};
  const TransportOperator op = build_operator(scene, 0, test::free_eta(), test::small_operator(500));
  ASSERT_EQ(op.light_channels, 1);
  const Medium<double> m{0.05, 1.2, 1.4};
  for (int c = 0; c < 3; ++c) {
    const ColumnCoefficients x = column_coefficients(op, test::dipole(), m, c);
    const auto check = [&](double Medium<double>::*member, const std::vector<double>& derivative) {
      const double h = 1e-5 * m.*member;
      Medium<double> above = m, below = m;
      above.*member += h, below.*member -= h;
      const auto hi = column_coefficients(op, test::dipole(), above, c).value,
                 lo = column_coefficients(op, test::dipole(), below, c).value;
      double largest = 0;
      for (const double d : derivative) largest = std::max(largest, std::abs(d));
      EXPECT_GT(largest, 0);
      ASSERT_EQ(derivative.size(), op.columns());
      for (std::size_t j = 0; j < derivative.size(); ++j)
        ASSERT_NEAR(derivative[j], (hi[j] - lo[j]) / (2 * h), 1e-7 * largest) << "channel " << c << " column " << j;
    };
    check(&Medium<double>::sigma_a, x.d_sigma_a);
    check(&Medium<double>::sigma_s_prime, x.d_sigma_s_prime);
    check(&Medium<double>::eta, x.d_eta);
    // The light's colour is in the coefficients.
    EXPECT_NEAR(x.value[40] / column_coefficients(op, test::dipole(), m, 0).value[40], std::pow(0.5, c), 1e-12);
  }
}

TEST(TransportOperator, MaskedPixelsHaveNoRowAndTheOthersStay) {
  const Scene scene = test::sphere_scene("skin1", 16);
  const OperatorSettings settings = test::small_operator(1500);
  const EtaNodes etas(1.3);
  const TransportOperator all = build_operator(scene, 0, etas, settings);
  std::vector<float> mask(16 * 16, 1.0f);
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (i % 3 == 0) mask[i] = i % 2 ? 0.0f : std::nanf("");
  const TransportOperator some = build_operator(scene, 0, etas, settings, mask);
  std::vector<std::uint32_t> expected;
  for (const std::uint32_t pixel : all.pixels)
    if (pixel % 3 != 0) expected.push_back(pixel);
  EXPECT_EQ(some.pixels, expected);
  EXPECT_EQ(some.counters.skipped.at("masked_pixels"), all.rows() - expected.size());
  const Image a = operator_image(all, test::dipole(), scene.materials[0]),
              b = operator_image(some, test::dipole(), scene.materials[0]);
  EXPECT_LT(test::relative_rms(some, b, a), 2e-5);  // other queries share a traversal, so clusters may differ
  const std::uint32_t off =
      *std::find_if(all.pixels.begin(), all.pixels.end(), [](std::uint32_t pixel) { return pixel % 3 == 0; });
  EXPECT_EQ(b.data[off * 4u + 3], 0);
  EXPECT_GT(a.data[off * 4u], 0);
  EXPECT_EQ(b.data[off * 4u], 0);
}

/// Two spheres of the fitted material with another one between them.
Scene three_spheres() {
  Scene scene = test::make_scene(make_sphere(2, 800), test::library_material("marble"), 12, 24);
  scene.materials.push_back(test::library_material("skin1"));
  scene.objects.push_back({"other", make_sphere(1.8, 800), 1});
  scene.objects.push_back({"second", make_sphere(1.5, 800), 0});
  for (glm::vec3& p : scene.objects[0].mesh.positions) p += glm::vec3(-3.9f, 0, 0);
  for (glm::vec3& p : scene.objects[2].mesh.positions) p += glm::vec3(3.9f, 1, 0);
  return scene;
}

TEST(TransportOperator, FitsAllObjectsOfTheMaterialAndNoOther) {
  const Scene scene = three_spheres();
  const OperatorSettings settings = test::small_operator();
  const Image truth = test::picture_of(scene, settings, "brute_force");
  for (const int material : {0, 1}) {
    const TransportOperator op = build_operator(scene, material, test::free_eta(), settings);
    const Scene& s = scene;
    const RayScene rays(s);
    std::vector<std::uint32_t> expected;
    for (const VisiblePoint& p : make_gbuffer(s, rays).points)
      if (s.objects[static_cast<std::size_t>(p.object)].material == material) expected.push_back(p.pixel);
    EXPECT_EQ(op.pixels, expected);
    EXPECT_GT(op.counters.skipped.at("pixels_of_other_materials"), 0u);
    const Image image = operator_image(op, test::dipole(), scene.materials[static_cast<std::size_t>(material)]);
    EXPECT_LT(test::relative_rms(op, image, truth), 1e-4) << "material " << material;
  }
}

TEST(TransportOperator, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = with_lights(test::sphere_scene("skin1", 20), two_colours());
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_operator(scene, 0, test::free_eta(), test::small_operator(1500));
  };
  const TransportOperator one = build(1), two = build(2);
  EXPECT_EQ(one.pixels, two.pixels);
  EXPECT_TRUE(one.values == two.values);
}

}  // namespace
}  // namespace opaline
