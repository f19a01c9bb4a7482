// The march of subsurface texture mapping alone: point by point against closed forms, on every vector target; how it
// reads textures; its phase functions; what it counts.
#include "render/subsurface/march.h"
#include "model/simd.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/gl_fixture.h"
#include "tests/support/layered_fixture.h"

#include <gmock/gmock.h>

#include <random>

namespace opaline {
namespace {

/// Runs for every vector target of this processor.
template <typename Body>
void on_every_target(Body&& body) {
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    SCOPED_TRACE(target);
    body();
  }
  limit_simd_target("");
}

/// A point of a flat surface, seen and lit from straight above, whose texture coordinates don't change.
FramedPoint flat_point(const glm::vec2& uv) {
  const glm::vec3 up(0, 0, 1);
  return {glm::vec3(0), up, up, up, 0, uv, glm::vec3(0), glm::vec3(0)};
}

std::vector<MarchResult> marched(const std::vector<FramedPoint>& points, const LayeredMedium& layers,
                                 const MarchSettings& settings) {
  const MarchMedium medium(layers);
  const MarchLight light{true, {0, 0, 1}, {1, 1, 1}};
  std::vector<MarchPoint> ready;
  for (const FramedPoint& p : points) ready.push_back(march_point(p, medium, std::span(&light, 1), 1));
  std::vector<MarchResult> results(points.size());
  march(ready, medium, std::span(&light, 1), settings, results.data());
  return results;
}

/// What an isotropic layer of that depth gives flat_point.
double closed_form(double sigma_s, double sigma_t, double depth) {
  return sigma_s / (4 * pi) * -std::expm1(-2 * sigma_t * depth) / (2 * sigma_t);
}

TEST(March, OneLayerIsTheClosedFormForEveryDepth) {
  on_every_target([] {
    for (double sigma_t = 1e-3; sigma_t < 300; sigma_t *= 1.7) {
      const Material m = test::even_layers({{Rgb(0.5 * sigma_t), Rgb(sigma_t), 0}}, {1});
      // 19 points: no vector is as long, so that there are whole ones and one that is not filled.
      for (const MarchResult& r : marched(std::vector(19, flat_point({0.5f, 0.5f})), *m.layers, {7, true, 0}))
        EXPECT_NEAR(static_cast<double>(r.radiance.g) / closed_form(0.5 * sigma_t, sigma_t, 1), 1, 5e-6) << sigma_t;
    }
  });
}

// What a march gives tells how deep its layer is there.
TEST(March, ReadsTexturesAsTheSceneDoes) {
  using Wrap = SurfaceTexture::Wrap;
  using Filter = SurfaceTexture::Filter;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> depth(0.1f, 1), place(-2.5f, 3.5f);
  std::vector<float> values(static_cast<std::size_t>(7 * 5));
  for (float& v : values) v = depth(random);
  values[11] = 1;  // where a march must go to
  std::vector<FramedPoint> points;
  for (int i = 0; i < 200; ++i) points.push_back(flat_point({place(random), place(random)}));
  for (const float u : {0.0f, 1.0f, -1.0f, 0.5f / 7, 1e9f, -1e-9f}) points.push_back(flat_point({u, 0.3f}));
  for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror})
    for (const Filter filter : {Filter::bilinear, Filter::nearest}) {
      SurfaceTexture texture = test::depth_image(7, 5, values);
      texture.wrap = wrap, texture.filter = filter;
      const Material m = test::layered_material({{Rgb(0.5), Rgb(1), 0}}, {texture});
      on_every_target([&] {
        const std::vector<MarchResult> results = marched(points, *m.layers, {1, true, 0});
        int off = 0;  // a coordinate rounded to the other side of a texel's edge
        for (std::size_t i = 0; i < points.size(); ++i) {
          float expected = 0;
          texture.sample(points[i].uv, 1, &expected);
          off += std::abs(static_cast<double>(results[i].radiance.r) / closed_form(0.5, 1, expected) - 1) > 1e-4;
        }
        EXPECT_LE(off, filter == Filter::nearest ? 2 : 0);
      });
    }
}

TEST(March, PhaseFunctionsAreTheModels) {
  std::vector<SubsurfaceLayer> layers;
  for (const double g : {-0.9999, -0.9, -0.2, 0.0, 0.4, 0.95})
    for (const Phase phase : {Phase::schlick, Phase::henyey_greenstein}) layers.push_back({Rgb(1), Rgb(1), g, phase});
  std::vector<SurfaceTexture> depths;
  for (std::size_t first = 0; first < layers.size(); first += 4) {
    const auto end = static_cast<float>(first + 1);
    depths.push_back(test::depth_image(1, 1, {end, end + 1, end + 2, end + 3}));
  }
  const Material m = test::layered_material(layers, depths);
  const MarchMedium medium(*m.layers);
  ASSERT_EQ(medium.stack.count, 12);
  for (std::size_t k = 0; k < layers.size(); ++k)
    for (double cosine = -1; cosine <= 1; cosine += 0.125) {
      const SubsurfaceLayer& layer = layers[k];
      const glm::dvec4 c(medium.phases[k]);
      const double exact =
          layer.phase == Phase::schlick ? schlick_phase(cosine, layer.g) : henyey_greenstein(cosine, layer.g);
      const double from_peak = c.y < 0 ? 1 + cosine : 1 - cosine;
      EXPECT_NEAR(c.z * std::pow(c.x + std::abs(c.y) * from_peak, c.w > 0 ? -2 : -1.5) / exact, 1, 2e-5)
          << k << " " << cosine;
    }
}

// flat_point is seen from where its light comes, so light turns right back: where g < 0 has its peak, in which float
// has no digits to lose.
TEST(March, KeepsTheDigitsOfAPeakBackwards) {
  for (const double g : {-0.9999, -0.99, -0.5, 0.5, 0.9999})
    for (const Phase phase : {Phase::schlick, Phase::henyey_greenstein}) {
      const Material m = test::even_layers({{Rgb(0.5), Rgb(1), g, phase}}, {1});
      const double to_isotropic =
          4 * pi * (phase == Phase::schlick ? schlick_phase(-1.0, g) : henyey_greenstein(-1.0, g));
      on_every_target([&] {
        const MarchResult r = marched({flat_point({0.5f, 0.5f})}, *m.layers, {7, true, 0})[0];
        EXPECT_NEAR(static_cast<double>(r.radiance.g) / (closed_form(0.5, 1, 1) * to_isotropic), 1, 1e-5) << g;
      });
    }
}

/// A thin slab of these layers, seen from straight above.
Scene thin_slab(double thickness, const Material& material, const glm::dvec3& light) {
  Scene scene = test::layered_scene(make_slab({80, 80, thickness}, 800), material, 4, 5, UvProjection::planar);
  scene.camera.position = {0, 0, 500};
  scene.lights = {DirectionalLight{glm::normalize(light), Rgb(1), 0}};
  return scene;
}

/// Relative difference of all pixels' green from a value, at most.
double furthest(const Frame& frame, double exact) {
  double error = frame.radiance.empty() ? 1e9 : 0;
  for (const glm::vec3& l : frame.radiance) error = std::max(error, std::abs(static_cast<double>(l.g) / exact - 1));
  return error;
}

// Light that crosses a slab: what scatters on the way, all of it equally faded. Its layers lie on both sides.
TEST(FarSide, AThinSlabLitFromBehindIsTheClosedForm) {
  const double thickness = 1, skin = 0.3, s0 = 1, t0 = 1.6, s1 = 2.5, t1 = 3;
  const Material m = test::even_layers({{Rgb(s0), Rgb(t0), 0}, {Rgb(s1), Rgb(t1), 0}}, {0.3f, 5});
  const Scene scene = thin_slab(thickness, m, {0, 0, 1});
  const double core = thickness - 2 * skin, through = std::exp(-2 * skin * t0 - core * t1);
  EXPECT_LT(furthest(test::render(scene, "subsurface_texture"), (2 * skin * s0 + core * s1) / (4 * pi) * through),
            2e-3);
  EXPECT_EQ(furthest(test::render(scene, "subsurface_texture", {{"far_side", "none"}}), 1), 1) << "the paper's is dark";
}

TEST(FarSide, LightThatCrossesASlabAtAnAngleIsTheClosedForm) {
  const double sigma_s = 1, sigma_t = 1.6, thickness = 0.8;
  const Scene scene = thin_slab(thickness, test::even_layers({{Rgb(sigma_s), Rgb(sigma_t), 0}}, {5}), {0.6, 0, 0.8});
  // Over depth z: up through z, down from the far side along 1.25 (thickness - z).
  const double rate = sigma_t * (1 - 1.25);
  const double exact =
      sigma_s / (4 * pi) * std::exp(-1.25 * sigma_t * thickness) * -std::expm1(-rate * thickness) / rate;
  EXPECT_LT(furthest(test::render(scene, "subsurface_texture"), exact), 1e-4);
}

TEST(FarSide, TheMarchEndsWhereTheViewLeaves) {
  const Scene scene = thin_slab(0.4, test::even_layers({{Rgb(0.5), Rgb(1), 0}}, {5}), {0, 0, -1});
  EXPECT_LT(furthest(test::render(scene, "subsurface_texture"), closed_form(0.5, 1, 0.4)), 1e-4);
}

// What is left out because it cannot matter doesn't; and there is much of it behind a thick object.
TEST(FarSide, SkippingThickWaysChangesNothing) {
  Scene scene = test::layered_scene(make_sphere(8, 3000), test::wavy_layers(), 18, 31, UvProjection::spherical);
  scene.lights = {DirectionalLight{{0.1, 0.2, 0.9}, Rgb(1), 0}};
  const Frame with = test::render(scene, "subsurface_texture"),
              without = test::render(scene, "subsurface_texture", {{"negligible", "0"}});
  double most = 0, brightest = 0;
  for (std::size_t i = 0; i < with.radiance.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      most = std::max(most, std::abs(static_cast<double>(with.radiance[i][c] - without.radiance[i][c])));
      brightest = std::max(brightest, static_cast<double>(without.radiance[i][c]));
    }
  EXPECT_GT(brightest, 0.01);
  EXPECT_LT(most, 2e-4 * brightest);
  EXPECT_GT(with.counters.skipped.at("light_paths_from_behind"),
            without.counters.skipped.at("light_paths_from_behind"));
}

TEST(FarSide, ApproachesTheExactMarchWhereASphereIsLitFromBehind) {
  Scene scene = test::layered_scene(make_sphere(1.5, 3000), test::even_layers(test::fish_layers(), {0.3f, 0.6f, 3}),
                                    3.4, 9, UvProjection::spherical);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.3, 0.2, 0.9)), Rgb(1), 0}};
  const Frame exact = test::render(scene, "single_scatter_exact", {{"max_relative_error", "1e-2"}});
  const auto error = [&](const char* far_side) {
    const Frame frame = test::render(scene, "subsurface_texture", {{"far_side", far_side}});
    double squares = 0, norm = 0;
    for (std::size_t i = 0; i < exact.radiance.size(); ++i) {
      const glm::dvec3 b(exact.radiance[i]), d = glm::dvec3(frame.radiance[i]) - b;
      squares += glm::dot(d, d), norm += glm::dot(b, b);
    }
    return std::sqrt(squares / norm);
  };
  EXPECT_LT(error("traced"), 0.2);
  EXPECT_GT(error("none"), 0.7);
}

/// A sphere of waving layers, lit from the side and by a point.
Scene wavy_sphere(int pixels) {
  Scene scene = test::layered_scene(make_sphere(10, 3000), test::wavy_layers(), 24, pixels, UvProjection::spherical);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.9, -0.3, -0.2)), Rgb(1), 0},
                  PointLight{{20, 30, 30}, Rgb(300)}};
  return scene;
}

TEST(March, IsTheSameOnEveryVectorTarget) {
  const Scene scene = wavy_sphere(31);
  for (const char* march : {"pieces", "paper"}) {
    limit_simd_target("");
    const Frame best = test::render(scene, "subsurface_texture", {{"march", march}});
    on_every_target([&] {
      const Frame frame = test::render(scene, "subsurface_texture", {{"march", march}});
      double most = 0;
      for (std::size_t i = 0; i < frame.radiance.size(); ++i)
        for (int c = 0; c < 3; ++c)
          most = std::max(most, std::abs(static_cast<double>(frame.radiance[i][c] - best.radiance[i][c])));
      EXPECT_LT(most, 3e-6);
    });
  }
}

// Who marches beside a point must not matter to it.
TEST(March, APointAloneIsWhatItIsAmongOthers) {
  const Scene scene = wavy_sphere(40);
  const SharedScene shared(scene, {1, {}}, false);
  const Technique& technique = find_technique("subsurface_texture");
  const auto prepared = technique.prepare(shared, Settings(technique.settings, {}));
  const Frame all = prepared->render(shared.view);
  for (std::size_t i = 3; i < shared.view.points.size(); i += 37) {
    GBuffer one = shared.view;
    one.points = {shared.view.points[i]};
    EXPECT_EQ(prepared->render(one).radiance[0], all.radiance[i]);
  }
}

TEST(March, EverySampleAndLightPathIsCountedOnce) {
  Scene scene = wavy_sphere(40);
  scene.lights.push_back(DirectionalLight{{0, 0, 1}, Rgb(1), 0});  // from behind all that is seen
  Mesh ball = make_sphere(3, 500);
  for (glm::vec3& p : ball.positions) p += glm::vec3(6, 9, 14);
  make_texture_coordinates(ball, UvProjection::spherical);
  scene.objects.push_back({"ball", ball, 0});  // throws a shadow
  const SharedScene shared(scene, {1, {}}, false);
  const Technique& technique = find_technique("subsurface_texture");
  const Settings settings(technique.settings, {{"negligible", "2e-3"}});
  const auto check = [&](const Frame& frame) {
    const auto& done = frame.counters.done;
    const auto& skipped = frame.counters.skipped;
    const std::uint64_t points = shared.view.points.size(), unmade = skipped.at("march_samples_behind_negligible") +
                                                                     skipped.at("march_samples_of_unlit_points");
    EXPECT_EQ(done.at("march_samples") + unmade, 50 * points);
    EXPECT_EQ(done.at("light_paths") + skipped.at("light_paths_from_behind") + skipped.at("light_paths_shadowed") +
                  skipped.at("light_paths_below_layers"),
              3 * (done.at("march_samples") + skipped.at("march_samples_of_unlit_points") + points));
    for (const char* name : {"march_samples_behind_negligible", "march_samples_of_unlit_points",
                             "light_paths_from_behind", "light_paths_shadowed", "light_paths_below_layers"})
      EXPECT_GT(skipped.at(name), 0u) << name;
    EXPECT_EQ(skipped.at("layers_nobody_reaches"), 0u);
  };
  const Frame cpu = technique.prepare(shared, settings)->render(shared.view);
  check(cpu);
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  const Frame gpu = technique.prepare_gpu(shared, settings, *context)->render(shared.view);
  check(gpu);
  for (const auto& [name, count] : cpu.counters.done)  // but for roundings at a threshold
    EXPECT_NEAR(static_cast<double>(gpu.counters.done.at(name)), static_cast<double>(count),
                2e-4 * static_cast<double>(count))
        << name;
}

TEST(March, ADarkSceneIsCountedAlikeByBothBackendsWithoutARay) {
  Scene scene = wavy_sphere(12);
  scene.lights = {};
  const SharedScene shared(scene, {1, {}}, false);
  const Technique& technique = find_technique("subsurface_texture");
  const Settings settings(technique.settings, {});
  const Frame cpu = technique.prepare(shared, settings)->render(shared.view);
  EXPECT_EQ(cpu.counters.done.at("far_side_rays"), 0u);
  EXPECT_EQ(cpu.counters.skipped.at("march_samples_of_unlit_points"), 50 * shared.view.points.size());
  const auto context = test::context_or_null();
  if (!context) GTEST_SKIP() << test::no_gl;
  const Frame gpu = technique.prepare_gpu(shared, settings, *context)->render(shared.view);
  EXPECT_EQ(gpu.radiance, cpu.radiance);
  EXPECT_EQ(gpu.counters.done, cpu.counters.done);
  EXPECT_EQ(gpu.counters.skipped, cpu.counters.skipped);
}

}  // namespace
}  // namespace opaline
