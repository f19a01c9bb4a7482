// Layered convolution as a technique: closed values, energy, convergence to the reference, and skips that change
// nothing.
#include "datasets_synthetic/shapes/shapes.h"
#include "model/fresnel.h"
#include "model/profiles/profile.h"
#include "render/input_error.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using Given = std::map<std::string, std::string>;
using testing::HasSubstr;

Frame render(const SharedScene& shared, const std::string& name, const Given& given) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given))->render(shared.view);
}

/// mode=given and some more.
Given with(Given more) {
  more.emplace("mode", "given");
  return more;
}

/// RMS of the difference over the RMS of the reference, all channels.
double rms_error(const Frame& frame, const Frame& reference) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < reference.exitance.size(); ++i) {
    const glm::dvec3 r(reference.exitance[i]), d = glm::dvec3(frame.exitance[i]) - r;
    error += glm::dot(d, d), norm += glm::dot(r, r);
  }
  return std::sqrt(error / norm);
}

Scene lit_slab(const glm::dvec3& size, double height, int pixels) {
  Scene scene = test::make_scene(make_slab(size, 3000), test::library_material("wholemilk"), height, pixels);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  return scene;
}

TEST(LayeredConvolution, AnEvenlyLitSlabGivesItsReflectance) {
  const Scene scene = lit_slab({160, 160, 40}, 20, 40);
  const SharedScene shared(scene, {6000, {}});
  const double eta = scene.materials[0].eta;
  for (const char* near : {"surface", "layers"})
    for (const char* resolution : {"100"}) {
      const Frame frame = render(shared, "layered_convolution",
                                 with({{"near", near}, {"resolution", resolution}, {"kernel", "compensated"}}));
      for (int c = 0; c < 3; ++c) {
        const double rho = find_profile("standard_dipole")->make(scene.materials[0].channel(c))->total();
        const double wanted = rho * fresnel_transmittance(1.0, eta);
        for (const glm::vec3& b : frame.exitance)
          ASSERT_NEAR(static_cast<double>(b[c]), wanted, 0.005 * wanted) << near << " " << resolution << " " << c;
      }
    }
}

// A beam on the middle of a slab: what comes out of the face it enters is rho times what went in.
TEST(LayeredConvolution, KeepsEnergyOverThePicture) {
  Scene scene = lit_slab({120, 120, 60}, 120, 240);
  scene.lights = {ProjectorLight{{0, 0, 200}, {0, 0, 0}, {0, 1, 0}, 10, Rgb(4e4), {}, {}, 0.8}};
  const SharedScene shared(scene, {20000, {}});
  double flux = 0;
  for (std::size_t i = 0; i < shared.cells[0].size(); ++i)
    flux += static_cast<double>(shared.irradiance[0].values[i] * cell_area(shared.cells[0][i]));
  ASSERT_GT(flux, 0);
  for (const char* near : {"surface", "layers"})
    for (const char* kernel : {"compensated", "pixel"}) {
      const Frame frame =
          render(shared, "layered_convolution", with({{"near", near}, {"resolution", "100"}, {"kernel", kernel}}));
      for (int c = 0; c < 3; ++c) {
        double out = 0;
        for (const glm::vec3& b : frame.exitance) out += static_cast<double>(b[c]) * 0.25;  // pixels of .5 mm
        const auto profile = find_profile("standard_dipole")->make(scene.materials[0].channel(c));
        // The disc inside the picture holds all but a little of the profile.
        EXPECT_GT(profile->cumulative(58), 0.99 * profile->total());
        EXPECT_NEAR(out, profile->cumulative(63) * flux, 0.005 * profile->total() * flux) << near << kernel << c;
      }
    }
}

class LayersConverge : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(LayersConverge, ToTheReference) {
  const auto& [splat, near] = GetParam();
  Scene scene = test::make_scene(make_torus(6, 2.5, 3000), test::library_material("skin1"), 19, 48);
  scene.camera = {Camera::Type::perspective, {20, -40, 90}, {0, 0, 0}, {0, 1, 0}, 11, 0};
  const SharedScene shared(scene, {8000, {}});
  const Frame reference = render(shared, "hierarchical", {});
  double last = HUGE_VAL;
  for (const char* layers : {"2", "4", "8", "16", "32"}) {
    const double error = rms_error(
        render(shared, "layered_convolution",
               with({{"layers", layers}, {"splat", splat}, {"near", near}, {"threshold", "0"}, {"resolution", "100"}})),
        reference);
    EXPECT_LT(error, last) << layers;
    last = error;
  }
  EXPECT_LT(last, splat == "linear" ? 0.025 : 0.05);
}

INSTANTIATE_TEST_SUITE_P(Splats, LayersConverge,
                         testing::Combine(testing::Values("linear", "half"), testing::Values("surface", "layers")),
                         [](const auto& row) { return std::get<0>(row.param) + "_" + std::get<1>(row.param); });

class LayeredProfiles : public testing::TestWithParam<std::string> {};

TEST_P(LayeredProfiles, RenderLikeTheReference) {
  Scene scene = test::make_scene(make_sphere(8, 1500), test::library_material("skin1"), 18, 40);
  const SharedScene shared(scene, {4000, {}});
  const Frame reference = render(shared, "hierarchical", {{"profile", GetParam()}});
  const Frame frame =
      render(shared, "layered_convolution", with({{"profile", GetParam()}, {"layers", "40"}, {"resolution", "200"}}));
  EXPECT_LT(rms_error(frame, reference), 0.04);
}

/// Of exitance: radiance along the normal is for flat objects, and much of it is a peak narrower than this scene's
/// grid.
std::vector<std::string> exitance_profiles() {
  std::vector<std::string> names;
  for (const std::string& name : medium_profile_names())
    if (!find_profile(name)->radiance) names.push_back(name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(Registry, LayeredProfiles, testing::ValuesIn(exitance_profiles()),
                         [](const auto& row) { return row.param; });

// --- skips ------------------------------------------------------------------------------------------

/// A ball in a corner of the film, lit from the side, with two equal channels.
Scene skip_scene() {
  Mesh ball = make_sphere(5, 1000);
  for (glm::vec3& p : ball.positions) p += glm::vec3(-6, 5, 0);
  Material material = test::library_material("marble");
  material.sigma_a = Rgb(0.05, 0.05, 0.2), material.sigma_s_prime = Rgb(2);
  return test::make_scene(std::move(ball), std::move(material), 24, 48);
}

struct Skip {
  std::string key, off, counter;
};

class LayeredSkips : public testing::TestWithParam<Skip> {};

TEST_P(LayeredSkips, ChangeNothingAndAreCounted) {
  const auto& [key, off, counter] = GetParam();
  Scene scene = skip_scene();
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};  // the far half is dark, and unseen
  const SharedScene shared(scene, {3000, {}});
  const Given base = with({{"layers", "12"}, {"resolution", "100"}, {"near", "layers"}});
  Given without = base;
  without[key] = off;
  const Frame on = render(shared, "layered_convolution", base), kept = render(shared, "layered_convolution", without);
  EXPECT_LT(rms_error(on, kept), key == "threshold" ? 1e-3 : 2e-6);
  EXPECT_GT(on.counters.skipped.at(counter), 0u);
  EXPECT_EQ(kept.counters.skipped.count(counter) ? kept.counters.skipped.at(counter) : 0, 0u);
}

INSTANTIATE_TEST_SUITE_P(Settings, LayeredSkips,
                         testing::Values(Skip{"dark_layers", "keep", "transforms_dark_layers"},
                                         Skip{"unseen_layers", "keep", "convolutions_unseen_layers"},
                                         Skip{"threshold", "0", "convolutions_below_threshold"},
                                         Skip{"rectangle", "film", "layer_nodes_outside_rectangle"},
                                         Skip{"equal_channels", "each", "equal_channels"}),
                         [](const auto& row) { return row.param.key; });

TEST(LayeredConvolution, CountsEveryPairOnceAndTransformsTwoForEachLayer) {
  const Scene scene = skip_scene();
  const SharedScene shared(scene, {3000, {}});
  const Frame all = render(shared, "layered_convolution",
                           with({{"layers", "6"},
                                 {"near", "layers"},
                                 {"threshold", "0"},
                                 {"dark_layers", "keep"},
                                 {"unseen_layers", "keep"},
                                 {"equal_channels", "each"},
                                 {"resolution", "100"}}));
  EXPECT_EQ(all.counters.done.at("convolutions"), 3u * 6 * 6);
  EXPECT_EQ(all.counters.done.at("transforms"), 6u + 3 * 6);  // light of one colour is transformed once
  const Frame few = render(shared, "layered_convolution",
                           with({{"layers", "6"}, {"near", "layers"}, {"threshold", "0.01"}, {"resolution", "100"}}));
  const auto& skipped = few.counters.skipped;
  EXPECT_EQ(few.counters.done.at("convolutions") + skipped.at("convolutions_below_threshold") +
                skipped.at("convolutions_unseen_layers") +
                (skipped.count("convolutions_dark_layers") ? skipped.at("convolutions_dark_layers") : 0),
            2u * 6 * 6);
}

TEST(LayeredConvolution, CoarserLayersAreNearlyAsGoodWhereTheProfileIsSmooth) {
  const Scene scene = test::make_scene(make_sphere(5, 4000), test::library_material("skin1"), 11, 160);
  const SharedScene shared(scene, {10000, {}});
  const Frame fine = render(shared, "layered_convolution", with({{"resolution", "100"}}));
  const Frame half = render(shared, "layered_convolution", with({{"resolution", "50"}}));
  const Frame quarter = render(shared, "layered_convolution", with({{"resolution", "25"}}));
  EXPECT_LT(rms_error(half, fine), 1e-3);
  EXPECT_LT(rms_error(quarter, fine), 4e-3);
  EXPECT_LT(12 * quarter.counters.done.at("layer_nodes"), fine.counters.done.at("layer_nodes"));
}

// --- what is picked ---------------------------------------------------------------------------------

TEST(LayeredConvolution, PicksSettingsForAnErrorAndSaysSo) {
  const Scene scene = test::make_scene(make_sphere(6, 2000), test::library_material("marble"), 14, 64);
  const SharedScene shared(scene, {6000, {}});
  const Frame reference = render(shared, "hierarchical", {});
  std::uint64_t work = 0;
  for (const double wanted : {0.1, 0.03}) {
    const Frame frame = render(shared, "layered_convolution", {{"wanted_error", std::to_string(wanted)}});
    ASSERT_EQ(frame.notes.size(), 1u);
    EXPECT_THAT(frame.notes[0], HasSubstr("object: "));
    EXPECT_THAT(frame.notes[0], HasSubstr(" layers, threshold "));
    EXPECT_LT(rms_error(frame, reference), wanted);
    EXPECT_GT(frame.counters.done.at("convolutions"), work);
    work = frame.counters.done.at("convolutions");
  }
}

TEST(LayeredConvolution, NamesWhatIsValid) {
  const Technique& technique = find_technique("layered_convolution");
  const auto message = [&](const Given& given) {
    return test::message_of([&] { Settings(technique.settings, given); });
  };
  EXPECT_THAT(message({{"layers", "2.5"}}), HasSubstr("'2.5' is not a whole number from 1 to 256"));
  EXPECT_THAT(message({{"splat", "cubic"}}), HasSubstr("'cubic' is not one of linear, half"));
}

// A film of one pixel, one layer, a camera close to the surface, no light: nothing breaks.
TEST(LayeredConvolution, SurvivesCorners) {
  for (const double distance : {5.01, 100.0}) {
    Scene scene = test::make_scene(make_sphere(5, 500), test::library_material("skin1"), 12, 8);
    scene.camera = {Camera::Type::perspective, {0, 0, distance}, {0, 0, 0}, {0, 1, 0}, 40, 0};
    for (const char* layers : {"1", "2", "16"}) {
      const SharedScene shared(scene, {1000, {}});
      for (const glm::vec3& b : render(shared, "layered_convolution", with({{"layers", layers}})).exitance)
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(b[c]) && b[c] >= 0) << distance << " " << layers;
    }
  }
}

}  // namespace
}  // namespace opaline
