// The twins: every technique with a CPU and a GPU backend makes the same picture on both, within its own tolerance,
// fed the same view and irradiance.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/render_scene.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/layered_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using testing::HasSubstr;

/// Everything a shader could get wrong: both cameras, one and three channels of light, shadows, several objects.
Scene twin_scene(const std::string& name) {
  if (name == "sphere") return test::make_scene(make_sphere(10, 320), test::library_material("skin1"), 22, 14);
  Scene scene = test::make_scene(make_torus(6, 2, 600), test::library_material("marble"), 18, 20);
  scene.camera = {Camera::Type::perspective, {5, -30, 40}, {0, 0, 0}, {0, 1, 0}, 22, 0};
  if (name == "torus") return scene;
  scene.lights.push_back(PointLight{{10, 20, 30}, Rgb(500, 300, 100)});
  scene.materials.push_back(test::library_material("wholemilk"));
  Mesh ball = make_sphere(2, 300);
  for (glm::vec3& p : ball.positions) p += glm::vec3(1, 0, 3);
  scene.objects.push_back({"ball", ball, 1});
  return scene;
}

/// The same with layers under every surface, for techniques that take nothing else.
Scene twin_scene(const std::string& name, const Technique& technique) {
  Scene scene = twin_scene(name);
  if (technique.materials.front() != MaterialKind::layered) return scene;
  for (Object& object : scene.objects)
    make_texture_coordinates(object.mesh, name == "sphere" ? UvProjection::spherical : UvProjection::planar);
  for (Material& material : scene.materials) material = test::wavy_layers();
  return scene;
}

std::vector<std::string> twins() {
  std::vector<std::string> names;
  for (const Technique& technique : techniques())
    if (std::find(technique.backends.begin(), technique.backends.end(), "gpu") != technique.backends.end())
      names.push_back(technique.name);
  return names;
}

/// Few layers, where the technique would pick many, and the cells as they are: twins need not be accurate.
std::map<std::string, std::string> coarse(const Technique& technique, std::map<std::string, std::string> given) {
  for (const SettingSpec& spec : technique.settings) {
    if (spec.key == "wanted_error") given.emplace(spec.key, "0.3");
    if (spec.key == "discretisation") given.emplace(spec.key, "fixed");
  }
  return given;
}

class Twins : public testing::TestWithParam<std::tuple<std::string, std::string>> {
 protected:
  const Technique& technique_ = find_technique(std::get<0>(GetParam()));
  const Scene scene_ = twin_scene(std::get<1>(GetParam()), technique_);

  /// Does a backend refuse these settings?
  bool refused(const gl::Context& context, const std::map<std::string, std::string>& given) const {
    const SharedScene shared(scene_, {600, {}}, technique_.needs_irradiance);
    const Settings settings(technique_.settings, coarse(technique_, given));
    try {
      technique_.prepare(shared, settings);
      technique_.prepare_gpu(shared, settings, context);
    } catch (const InputError&) {
      return true;
    }
    return false;
  }

  /// RMS difference over the RMS of the CPU's picture.
  double difference(const gl::Context& context, const std::map<std::string, std::string>& given) const {
    const SharedScene shared(scene_, {600, {}}, technique_.needs_irradiance);
    const Settings settings(technique_.settings, coarse(technique_, given));
    const Frame cpu = technique_.prepare(shared, settings)->render(shared.view);
    const Frame gpu = technique_.prepare_gpu(shared, settings, context)->render(shared.view);
    const std::vector<glm::vec3>&one = cpu.radiance.empty() ? cpu.exitance : cpu.radiance,
          &other = cpu.radiance.empty() ? gpu.exitance : gpu.radiance;
    EXPECT_EQ(one.size(), other.size());
    double squares = 0, norm = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      const glm::dvec3 a(one[i]), d = glm::dvec3(other[i]) - a;
      squares += glm::dot(d, d), norm += glm::dot(a, a);
    }
    return std::sqrt(squares / norm);
  }
};

TEST_P(Twins, Agree) {
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  ASSERT_GT(technique_.twin_tolerance, 0);
  const double by_default = difference(*context, {});
  RecordProperty("difference", std::to_string(by_default));
  EXPECT_LT(by_default, technique_.twin_tolerance);
  // And with every word that a setting can have, as far as both backends take it; of the profiles one more.
  for (const SettingSpec& spec : technique_.settings)
    for (const std::string& choice : spec.choices) {
      if (choice == spec.fallback || refused(*context, {{spec.key, choice}})) continue;
      if (spec.key == "profile" && choice != "normalised_diffusion") continue;
      if (spec.key == "discretisation") continue;  // the twins get their cells from one function
      EXPECT_LT(difference(*context, {{spec.key, choice}}), technique_.twin_tolerance) << spec.key << "=" << choice;
    }
}

INSTANTIATE_TEST_SUITE_P(Registry, Twins,
                         testing::Combine(testing::ValuesIn(twins()),
                                          testing::Values("sphere", "torus", "two_objects")),
                         [](const auto& row) { return std::get<0>(row.param) + "_" + std::get<1>(row.param); });

TEST(Backends, AreWhatTheRegistrySays) {
  for (const Technique& technique : techniques()) {
    const auto& b = technique.backends;
    EXPECT_EQ(std::find(b.begin(), b.end(), "gpu") != b.end(), technique.prepare_gpu != nullptr) << technique.name;
  }
}

TEST(Backends, TheGpuNamesItsDeviceAndTheCpuMakesNoContext) {
  if (!test::context_or_null()) GTEST_SKIP() << test::no_gl;
  const Scene scene = twin_scene("sphere");
  RenderOptions options;
  options.technique = "image_space_sampling";
  EXPECT_EQ(render_scene(scene, options).device, "");
  options.backend = "gpu", options.gl = "osmesa";
  EXPECT_THAT(render_scene(scene, options).device, HasSubstr("OSMesa"));
  options.gl = "direct3d";
  EXPECT_THAT(test::message_of([&] { render_scene(scene, options); }),
              HasSubstr("--gl: 'direct3d' is not one of egl, osmesa"));
  options.gl = "", options.settings = {{"views", "camera+light"}};
  EXPECT_THAT(test::message_of([&] { render_scene(scene, options); }),
              HasSubstr("the gpu backend has the camera's view"));
}

}  // namespace
}  // namespace opaline
