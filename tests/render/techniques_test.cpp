// Every registered technique, and what they share: the exit lobe, the shared scene.
#include "render/techniques/technique.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "model/fresnel.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/layered_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>

#include <set>

namespace opaline {
namespace {

using testing::HasSubstr;

Scene small_sphere() { return test::make_scene(make_sphere(10, 500), test::library_material("skin1"), 22, 24); }

bool takes_layers(const Technique& technique) { return technique.materials.front() == MaterialKind::layered; }

/// Of a material that the technique takes.
Scene small_sphere(const Technique& technique) {
  Scene scene = small_sphere();
  if (!takes_layers(technique)) return scene;
  make_texture_coordinates(scene.objects[0].mesh, UvProjection::spherical);
  scene.materials = {test::even_layers(test::fish_layers(), {0.3f, 0.6f, 3})};
  return scene;
}

/// All lit surface is in view.
Scene seen_slab() {
  Scene scene = test::make_scene(make_slab({30, 30, 10}, 500), test::library_material("skin1"), 36, 48);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  return scene;
}

SharedSettings few_samples() {
  SharedSettings settings;
  settings.samples = 4000;
  return settings;
}

/// The defaults, but as little chance as possible.
std::map<std::string, std::string> quick(const Technique& technique) {
  if (technique.statistical) return {{"paths", "2"}};
  if (technique.name == "single_scatter_exact") return {{"max_relative_error", "0.5"}};
  return {};
}

Frame render(const Technique& technique, const SharedScene& shared,
             const std::map<std::string, std::string>& set = {}) {
  return technique.prepare(shared, Settings(technique.settings, set))->render(shared.view);
}

/// Exitance or radiance, whichever it is.
const std::vector<glm::vec3>& values(const Frame& frame) {
  EXPECT_NE(frame.exitance.empty(), frame.radiance.empty());
  return frame.radiance.empty() ? frame.exitance : frame.radiance;
}

class EveryTechnique : public testing::TestWithParam<std::string> {
 protected:
  const Technique& technique() const { return find_technique(GetParam()); }
};

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const Technique& technique : techniques()) all.push_back(technique.name);
  return all;
}

TEST_P(EveryTechnique, SaysWhatItIs) {
  const Technique& t = technique();
  EXPECT_FALSE(t.summary.empty());
  EXPECT_GT(t.citation.size(), 20u);
  EXPECT_FALSE(t.limits.empty());
  EXPECT_FALSE(t.backends.empty());
  for (const std::string& backend : t.backends) EXPECT_TRUE(backend == "cpu" || backend == "gpu") << backend;
}

TEST_P(EveryTechnique, HasSettingsWithMeaningAndValidDefaults) {
  std::set<std::string> keys;
  for (const SettingSpec& spec : technique().settings) {
    EXPECT_FALSE(spec.meaning.empty()) << spec.key;
    EXPECT_TRUE(keys.insert(spec.key).second) << spec.key << " twice";
    EXPECT_TRUE(!spec.choices.empty() || spec.text || spec.lo < spec.hi) << spec.key;
  }
  EXPECT_NO_THROW(Settings(technique().settings, {}));
}

/// Settings that buy accuracy with time, for techniques whose defaults are noisier than the test allows; and the cells
/// of the shared scene as they are.
std::map<std::string, std::string> accurate(const Technique& technique) {
  std::map<std::string, std::string> given;
  for (const SettingSpec& spec : technique.settings) {
    if (spec.key == "samples_per_pixel") given[spec.key] = "1024";
    if (spec.key == "wanted_error") given[spec.key] = "0.002";
    // A table's error is relative to even light from everywhere: the dark needs a smaller one.
    if (spec.key == "directions") given = {{spec.key, "50000"}, {"subdivide", "8"}, {"max_relative_error", "1e-4"}};
    if (spec.key == "discretisation") given[spec.key] = "fixed";
  }
  return given;
}

// A sphere lit from the side; or, for a technique that gathers only what it sees, a slab lit and seen from above.
TEST_P(EveryTechnique, RendersLikeTheSumOverAllCells) {
  if (technique().statistical) GTEST_SKIP() << "follows transport, not a diffusion profile";
  if (takes_layers(technique())) GTEST_SKIP() << "single scattering, no diffusion profile";
  const Scene scene = technique().only_visible ? seen_slab() : small_sphere();
  ASSERT_EQ(why_not_applicable(technique(), scene), "");
  // One that lights cells of its own meets the sum over others only where both are small.
  SharedSettings samples = few_samples();
  if (!technique().needs_irradiance) samples.samples = 40000;
  const SharedScene shared(scene, samples);
  const Frame exact = render(find_technique("brute_force"), shared),
              frame = render(technique(), shared, accurate(technique()));
  ASSERT_EQ(frame.exitance.size(), shared.view.points.size());
  const float floor = 1e-3f * test::mean_lit_irradiance(shared.cells[0], shared.irradiance[0]);
  for (int c = 0; c < 3; ++c) {
    const auto difference = test::relative_difference(frame.exitance, exact.exitance, c, floor);
    EXPECT_GT(difference.count, 200u);
    EXPECT_LT(difference.rms, 0.02) << "channel " << c;
  }
}

TEST_P(EveryTechnique, FillsEveryVisiblePoint) {
  const Scene scene = small_sphere(technique());
  ASSERT_EQ(why_not_applicable(technique(), scene), "");
  const SharedScene shared(scene, few_samples(), technique().needs_irradiance);
  const Frame frame = render(technique(), shared, quick(technique()));
  EXPECT_EQ(values(frame).size(), shared.view.points.size());
  EXPECT_EQ(frame.images.count("variance"), technique().statistical ? 1u : 0u);
  for (const auto& [name, image] : frame.images) EXPECT_EQ(image.size(), shared.view.points.size()) << name;
}

// If an edit of the camera does not invalidate it, what was prepared must serve another view.
TEST_P(EveryTechnique, ServesANewViewAsItSays) {
  if (technique().invalidated_by.camera) GTEST_SKIP() << "needs preparing for every view";
  const Scene front = small_sphere(technique());
  Scene side = front;
  side.camera.position = {-150, 100, 100};
  const SharedScene from_front(front, few_samples()), from_side(side, few_samples());
  const Settings settings(technique().settings, quick(technique()));
  const auto prepared = technique().prepare(from_front, settings), fresh = technique().prepare(from_side, settings);
  EXPECT_EQ(values(prepared->render(from_side.view)), values(fresh->render(from_side.view)));
}

TEST_P(EveryTechnique, LightDoesNotCrossFromObjectToObject) {
  Scene scene = small_sphere(technique());
  Mesh shaded = make_sphere(4, 200);  // behind the first sphere in the light's direction
  const glm::vec3 away = 16.0f * glm::vec3(std::get<DirectionalLight>(scene.lights[0]).direction);
  for (glm::vec3& p : shaded.positions) p += away;
  if (takes_layers(technique())) make_texture_coordinates(shaded, UvProjection::spherical);
  scene.objects.push_back({"shaded", shaded, 0});
  scene.camera.height = 50;
  const SharedScene shared(scene, few_samples());
  const Frame frame = render(technique(), shared, quick(technique()));
  const ObjectPoints points = points_of_object(shared.view, 1);
  ASSERT_GT(points.indices.size(), 5u);
  for (const std::uint32_t i : points.indices) EXPECT_EQ(values(frame)[i], glm::vec3(0));
  std::size_t lit = 0;
  const ObjectPoints front = points_of_object(shared.view, 0);
  for (const std::uint32_t i : front.indices) lit += values(frame)[i].r > 0;
  // Light that is scattered once does not come far round to the dark side.
  const bool some = technique().statistical || takes_layers(technique());
  EXPECT_GT(lit, some ? front.indices.size() / 2 : front.indices.size() - 1);
}

TEST_P(EveryTechnique, ATechniqueWithoutLightIsBlack) {
  Scene scene = small_sphere(technique());
  scene.lights = {PointLight{{0, 0, 50}, Rgb(0)}};
  const SharedScene shared(scene, few_samples());
  const Frame frame = render(technique(), shared, quick(technique()));
  for (const glm::vec3& b : values(frame)) EXPECT_EQ(b, glm::vec3(0));
}

INSTANTIATE_TEST_SUITE_P(Registry, EveryTechnique, testing::ValuesIn(names()),
                         [](const auto& row) { return row.param; });

TEST(Techniques, NamesAreUniqueAndFound) {
  std::set<std::string> unique;
  for (const std::string& name : names()) {
    EXPECT_TRUE(unique.insert(name).second) << name;
    EXPECT_EQ(&find_technique(name), &find_technique(name));
    EXPECT_EQ(find_technique(name).name, name);
  }
  EXPECT_TRUE(unique.count("brute_force")) << "the oracle of the others";
}

TEST(Techniques, AnUnknownNameIsAnErrorThatNamesTheValidOnes) {
  const std::string message = test::message_of([] { find_technique("magic"); });
  EXPECT_THAT(message, HasSubstr("--technique: 'magic' is not one of "));
  for (const std::string& name : names()) EXPECT_THAT(message, HasSubstr(name));
}

TEST(Hierarchical, SettingsReachTheGather) {
  const Scene scene = small_sphere();
  const SharedScene shared(scene, few_samples());
  const Technique& hierarchical = find_technique("hierarchical");
  const Frame exact = render(find_technique("brute_force"), shared);
  const auto rms = [&](const std::map<std::string, std::string>& set) {
    return test::relative_difference(render(hierarchical, shared, set).exitance, exact.exitance, 0, 1e-3f).rms;
  };
  EXPECT_LT(rms({{"max_relative_error", "1e-4"}, {"discretisation", "fixed"}}), 1e-4);
  EXPECT_GT(rms({{"criterion", "solid_angle"}, {"quality", "1"}}), 0.03);
  EXPECT_LT(rms({{"criterion", "solid_angle"}, {"quality", "0.2"}}),
            rms({{"criterion", "solid_angle"}, {"quality", "1"}}));
}

// --- the shared scene ------------------------------------------------------------------------------

TEST(SharedScene, HoldsCellsAndIrradianceOfEveryObject) {
  Scene scene = small_sphere();
  scene.materials.push_back(test::library_material("marble"));
  Mesh second = make_sphere(5, 200);
  for (glm::vec3& p : second.positions) p.x += 40;
  scene.objects.push_back({"second", second, 1});
  const SharedScene shared(scene, few_samples());
  ASSERT_EQ(shared.cells.size(), 2u);
  ASSERT_EQ(shared.irradiance.size(), 2u);
  std::size_t cells = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    cells += shared.cells[i].size();
    EXPECT_EQ(shared.irradiance[i].values.size(), shared.cells[i].size());
  }
  EXPECT_GE(cells, 3990u);
  EXPECT_EQ(shared.counters.done.at("surface_cells"), cells);
  EXPECT_EQ(shared.counters.done.at("camera_rays"), 24u * 24u);
  EXPECT_GT(shared.counters.done.at("shadow_rays"), 0u);
  // Each object's light entered through its own index: at the middle of the lit side F_t is that of the normal.
  const double light = glm::length(std::get<DirectionalLight>(scene.lights[0]).irradiance) / std::sqrt(3.0);
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& values = shared.irradiance[i].values;
    const double eta = scene.materials[static_cast<std::size_t>(scene.objects[i].material)].eta;
    EXPECT_NEAR(*std::max_element(values.begin(), values.end()), light * fresnel_transmittance(1.0, eta), 4e-3);
  }
}

// --- the exit lobe ---------------------------------------------------------------------------------

constexpr int directions = 64;

/// A view of one object whose points have the cosines sqrt((i + 1/2) / n): the midpoint rule of
/// 2 int f(c) c dc.
GBuffer all_directions() {
  GBuffer view;
  view.width = directions, view.height = 1;
  for (std::uint32_t i = 0; i < directions; ++i)
    view.points.push_back({i, 0, 0, {}, {0, 0, 1}, static_cast<float>(std::sqrt((i + 0.5) / directions))});
  return view;
}

/// Outgoing flux per area, int L cos dw = pi * the mean of L over the midpoints, in one channel.
double outgoing(double eta, ExitLobe lobe, int channel) {
  Scene scene = small_sphere();
  scene.materials[0].eta = eta;
  const Image image = shade(scene, all_directions(), std::vector<glm::vec3>(directions, glm::vec3(2, 1, 0.5f)), lobe);
  double mean = 0;
  for (int x = 0; x < directions; ++x) mean += static_cast<double>(image.at(x, 0, channel)) / directions;
  return pi * mean;
}

TEST(Shade, TheNormalisedLobeSendsOutWhatLeavesTheMedium) {
  for (const double eta : {1.0, 1.1, 1.3, 1.5, 2.0}) {
    EXPECT_NEAR(outgoing(eta, ExitLobe::normalised, 0), 2, 2 * 2e-3) << eta;
    EXPECT_NEAR(outgoing(eta, ExitLobe::normalised, 1), 1, 2e-3) << eta;
    EXPECT_NEAR(outgoing(eta, ExitLobe::normalised, 2), 0.5, 0.5 * 2e-3) << eta;
  }
}

TEST(Shade, TheJensenLobeLosesTheDiffuseFresnelReflectance) {
  // Walsh's formula, n = 1.3: 0.0611, n = 1.5: 0.0918 (also Duntley 1942); 2 C_1(1/eta) in the papers.
  EXPECT_NEAR(outgoing(1.3, ExitLobe::jensen, 1), 1 - 0.0611, 2e-3);
  EXPECT_NEAR(outgoing(1.5, ExitLobe::jensen, 1), 1 - 0.0918, 2e-3);
  EXPECT_NEAR(outgoing(1.0, ExitLobe::jensen, 1), 1, 1e-6);
}

TEST(Shade, LeavesRadianceAsItIsAndShadesImagesBesideExitance) {
  const Scene scene = small_sphere();
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  Frame frame;
  frame.images["bound"].assign(view.points.size(), glm::vec3(0.25f));
  frame.exitance.assign(view.points.size(), glm::vec3(1, 2, 3));
  const Image image = shade(scene, view, frame), bound = shade_layers(scene, view, frame).at("bound");
  EXPECT_EQ(image.data, shade(scene, view, frame.exitance).data);
  EXPECT_FLOAT_EQ(bound.at(12, 12, 0), image.at(12, 12, 0) / 4);
  std::swap(frame.exitance, frame.radiance);
  EXPECT_EQ(shade(scene, view, frame).at(12, 12, 2), 3);
  EXPECT_EQ(shade_layers(scene, view, frame).at("bound").at(12, 12, 2), 0.25f);
  const Image all = with_layers(shade(scene, view, frame), shade_layers(scene, view, frame));
  EXPECT_EQ(all.channels, (std::vector<std::string>{"R", "G", "B", "A", "bound.R", "bound.G", "bound.B"}));
  EXPECT_EQ(all.at(12, 12, 1), 2);
  EXPECT_EQ(all.at(12, 12, all.channel("bound.G")), 0.25f);
  EXPECT_EQ(all.at(0, 0, 0), 0);
}

TEST(Shade, WritesPixelsAndTheirCoverage) {
  const Scene scene = small_sphere();
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  const Image image = shade(scene, view, std::vector<glm::vec3>(view.points.size(), glm::vec3(1)));
  EXPECT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  double covered = 0;
  for (std::size_t i = 0; i < image.pixel_count(); ++i) covered += static_cast<double>(image.data[4 * i + 3]);
  EXPECT_EQ(covered, static_cast<double>(view.points.size()));
  EXPECT_EQ(image.at(0, 0, 0), 0);
  EXPECT_EQ(image.at(0, 0, 3), 0);
  // The middle, seen head on: F_t(1) / (pi c).
  const double c = 1 - diffuse_reflectance_external(1.3);
  EXPECT_NEAR(image.at(12, 12, 1), fresnel_transmittance(1.0, 1.3) / (pi * c), 1e-3);
}

}  // namespace
}  // namespace opaline
