// Subsurface texture mapping and the exact single scattering it is judged by: against closed forms, and each other.
#include "model/single_scattering/layered.h"
#include "render/subsurface/depth_texture.h"
#include "render/subsurface/exact_march.h"
#include "render/subsurface/texture_mapping.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/layered_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using test::render;
using testing::HasSubstr;

// --- layers along a way -----------------------------------------------------------------------------

TEST(LayerPieces, AreWhereTheBoundariesAre) {
  const float at_a[] = {1, 2, 2, 5}, at_b[] = {1, 3, 3, 4};
  for (const auto& [from, to] : {std::pair(0.0f, 6.0f), std::pair(6.0f, 0.0f), std::pair(0.5f, 0.6f),
                                 std::pair(1.0f, 2.0f), std::pair(2.5f, 2.5f)}) {
    const LayerPlace a(from, at_a, 4), b(to, at_b, 4);
    float end = 0;
    for_each_piece(a, b, 4, [&](int layer, float t0, float t1) {
      EXPECT_EQ(t0, end);
      end = t1;
      for (int i = 0; i < 50; ++i) {
        const float t = t0 + (t1 - t0) * (static_cast<float>(i) + 0.5f) / 50, depth = from + t * (to - from);
        int expected = 0;
        while (expected < 4 && depth >= at_a[expected] + t * (at_b[expected] - at_a[expected])) ++expected;
        EXPECT_EQ(layer, expected) << "from " << from << " to " << to << " at " << t;
      }
    });
    EXPECT_EQ(end, 1);
  }
}

TEST(LayerPieces, MeanTransmittanceIsTheIntegral) {
  for (const double delta : {-3.0, -0.021, -0.019, -1e-4, 0.0, 1e-6, 0.019, 0.021, 0.5, 20.0}) {
    const double exact = delta == 0 ? 1 : -std::expm1(-delta) / delta;
    EXPECT_NEAR(static_cast<double>(mean_transmittance(static_cast<float>(delta))) / exact, 1, 3e-7) << delta;
  }
}

TEST(LayeredMedium, BoundariesNeverRise) {
  const Material m = test::even_layers(test::fish_layers(), {0.5f, 0.2f, 0.9f});
  float depth[3];
  m.layers->boundaries({0.3f, 0.3f}, depth);
  EXPECT_EQ(depth[0], 0.5f);
  EXPECT_EQ(depth[1], 0.5f) << "a layer of no thickness";
  EXPECT_EQ(depth[2], 0.9f);
  EXPECT_FLOAT_EQ(static_cast<float>(m.layers->largest_depth()), 0.9f);
  const std::vector<double> thickness = m.layers->largest_thickness();
  EXPECT_EQ(thickness[1], 0);
  EXPECT_NEAR(thickness[2], 0.4, 1e-6);
}

// --- depth textures from meshes ---------------------------------------------------------------------

TEST(DepthTextures, AreTheDistancesToTheLayersMeshes) {
  Mesh surface = make_sphere(10, 20000);
  make_texture_coordinates(surface, UvProjection::spherical);
  const std::vector<Mesh> layers = {make_sphere(9, 20000), make_sphere(9.5, 5000), make_sphere(7, 20000),
                                    make_sphere(2, 5000), make_slab({1, 1, 0.5}, 12)};
  Counters counters;
  const std::vector<Image> images = make_depth_textures(surface, layers, 64, 32, 6, counters);
  ASSERT_EQ(images.size(), 2u);
  EXPECT_EQ(images[0].channels, (std::vector<std::string>{"R", "G", "B", "A"}));
  EXPECT_EQ(images[1].channels, (std::vector<std::string>{"R"}));
  for (int y = 1; y < 31; ++y)
    for (int x = 0; x < 64; ++x) {
      EXPECT_NEAR(images[0].at(x, y, 0), 1, 0.02);
      EXPECT_NEAR(images[0].at(x, y, 1), 1, 0.02) << "never less than the layer above";
      EXPECT_NEAR(images[0].at(x, y, 2), 3, 0.02);
      EXPECT_EQ(images[0].at(x, y, 3), 6) << "the deepest that was asked for";
    }
  EXPECT_GT(counters.done.at("rays"), 5u * 1900u);
}

TEST(DepthTextures, FillTexelsThatNoTriangleCovers) {
  Mesh surface;
  surface.positions = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}};
  surface.uvs = {{0.25f, 0.25f}, {0.75f, 0.25f}, {0.75f, 0.75f}, {0.25f, 0.75f}};
  surface.triangles = {{0, 1, 2}, {0, 2, 3}};
  Mesh below = surface;
  for (glm::vec3& p : below.positions) p = {3 * p.x - 10, 3 * p.y - 10, -0.1f * p.x - 1};
  Counters counters;
  const std::vector<Image> images = make_depth_textures(surface, std::span(&below, 1), 16, 16, 9, counters);
  for (int x = 4; x < 12; ++x) {
    const float place = 10 * ((static_cast<float>(x) + 0.5f) / 16 - 0.25f) / 0.5f;
    EXPECT_NEAR(images[0].at(x, 8, 0), 1 + 0.1f * (place + 10) / 3, 1e-4);
  }
  EXPECT_EQ(counters.skipped.at("texels_off_surface"), 16u * 16u - 64u);
  for (const float depth : images[0].data) EXPECT_GE(depth, 1.0f);
}

// --- planes and tangent frames ----------------------------------------------------------------------

TEST(SurfaceFrames, FitThePlaneOfAFlatNeighbourhoodExactly) {
  Mesh mesh = make_slab({20, 10, 5}, 2000);
  make_texture_coordinates(mesh, UvProjection::planar);
  const SurfaceFrames frames = make_surface_frames(mesh, 1.5);
  EXPECT_EQ(frames.without_plane, 0u);
  std::size_t inner = 0;
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const glm::vec3 p = mesh.positions[i];
    if (mesh.normals[i].z < 0.5f || std::abs(p.x) > 8 || std::abs(p.y) > 3) continue;
    ++inner;
    EXPECT_NEAR(frames.plane_normal[i].z, 1, 1e-6);
    EXPECT_NEAR(frames.plane_height[i], 0, 1e-6);
    EXPECT_NEAR(frames.gradient_u[i].x, 1.0 / 20, 1e-6);
    EXPECT_NEAR(frames.gradient_v[i].y, 1.0 / 10, 1e-6);
    EXPECT_NEAR(frames.gradient_u[i].y, 0, 1e-6);
  }
  EXPECT_GT(inner, 100u);
}

// The vertices of a sphere within r of one of them form a cap; its mean depth below the pole is r^2 / (4 R).
TEST(SurfaceFrames, LieBelowTheTopOfASphere) {
  Mesh mesh = make_sphere(10, 20000);
  make_texture_coordinates(mesh, UvProjection::spherical);
  const SurfaceFrames frames = make_surface_frames(mesh, 2);
  EXPECT_EQ(frames.without_plane, 0u);
  for (std::size_t i = 0; i < mesh.positions.size(); i += 97) {
    EXPECT_NEAR(frames.plane_height[i], -4.0 / 40, 0.012);
    EXPECT_GT(glm::dot(frames.plane_normal[i], mesh.normals[i]), 0.999f);
  }
}

TEST(SurfaceFrames, WithoutAPlaneTheTangentPlaneStandsInAndIsCounted) {
  Mesh sparse = make_sphere(10, 20), thin;
  make_texture_coordinates(sparse, UvProjection::spherical);
  const SurfaceFrames few = make_surface_frames(sparse, 0.5);
  EXPECT_EQ(few.without_plane, sparse.positions.size());
  EXPECT_EQ(few.plane_normal[3], sparse.normals[3]);
  // Vertices in a line.
  for (int i = 0; i < 5; ++i) thin.positions.emplace_back(static_cast<float>(i), 0, 0);
  thin.positions.emplace_back(100, 100, 0);
  thin.normals.assign(6, glm::vec3(0, 0, 1));
  thin.uvs.assign(6, glm::vec2(0.5f));
  thin.triangles = {{0, 4, 5}};
  const SurfaceFrames line = make_surface_frames(thin, 10);
  EXPECT_EQ(line.without_plane, 6u);
  EXPECT_EQ(line.without_gradient, 6u);
}

// --- flat slabs against closed forms ----------------------------------------------------------------

/// A wide slab seen and lit at an angle, by a directional light.
Scene flat_slab(const Material& material, int pixels = 5) {
  Scene scene = test::layered_scene(make_slab({80, 80, 30}, 800), material, 4, pixels, UvProjection::planar);
  scene.camera.position = {40, 0, 80};
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.3, 0.4, -0.8)), Rgb(3, 2, 1), 0}};
  return scene;
}

std::vector<ScatteringLayer<double>> channel_layers(const Material& m, int c, double eta) {
  std::vector<ScatteringLayer<double>> layers;
  float depth[LayeredMedium::most_layers], above = 0;
  m.layers->boundaries({0.5f, 0.5f}, depth);
  for (std::size_t k = 0; k < m.layers->layers.size(); ++k) {
    const SubsurfaceLayer& layer = m.layers->layers[k];
    layers.push_back({{layer.sigma_t[c] - layer.sigma_s[c], layer.sigma_s[c], layer.g, eta, layer.phase},
                      static_cast<double>(depth[k] - above)});
    above = depth[k];
  }
  return layers;
}

/// What a flat stack of layers sends to the camera of flat_slab.
Rgb closed_form(const Scene& scene, double eta = 1) {
  const auto& light = std::get<DirectionalLight>(scene.lights[0]);
  const glm::dvec3 w_i = -light.direction, w_o = glm::normalize(scene.camera.position - scene.camera.look_at);
  const glm::dvec2 in(light.direction), out(w_o);
  const double azimuth = glm::dot(in, out) / (glm::length(in) * glm::length(out));
  Rgb radiance;
  for (int c = 0; c < 3; ++c)
    radiance[c] = light.irradiance[c] * w_i.z *
                  layered_single_scattering_brdf(channel_layers(scene.materials[0], c, eta), w_i.z, w_o.z, azimuth);
  return radiance;
}

/// Largest relative error over pixels and channels.
double worst(const Frame& frame, const Rgb& exact) {
  double error = 0;
  EXPECT_FALSE(frame.radiance.empty());
  for (const glm::vec3& l : frame.radiance)
    for (int c = 0; c < 3; ++c) error = std::max(error, std::abs(static_cast<double>(l[c]) / exact[c] - 1));
  return error;
}

Material one_layer(Phase phase = Phase::schlick, double g = 0.25) {
  return test::even_layers({{Rgb(2, 1, 1), Rgb(2.6, 1.6, 1.6), g, phase}}, {3});
}
Material two_layers() {
  return test::even_layers({{Rgb(2, 1, 1), Rgb(2.6, 1.6, 1.6), 0.25}, {Rgb(6, 3, 2), Rgb(6.6, 3.6, 2.6), 0.4}},
                           {0.4f, 1.7f});
}
Material three_layers() { return test::even_layers(test::fish_layers(), {0.33f, 0.61f, 3.1f}); }

TEST(SubsurfaceTexture, OneFlatLayerIsTheClosedForm) {
  for (const Material& m : {one_layer(), one_layer(Phase::henyey_greenstein, -0.6), one_layer(Phase::schlick, 0.95)}) {
    const Scene scene = flat_slab(m);
    for (const char* n : {"1", "10", "100"})
      EXPECT_LT(worst(render(scene, "subsurface_texture", {{"samples_per_pixel", n}}), closed_form(scene)), 2e-4) << n;
  }
}

TEST(SubsurfaceTexture, ThePapersSumConvergesAsOneOverN) {
  const Scene scene = flat_slab(one_layer());
  const auto error = [&](const char* n) {
    return worst(render(scene, "subsurface_texture", {{"samples_per_pixel", n}, {"march", "paper"}}),
                 closed_form(scene));
  };
  const double coarse = error("100"), fine = error("400"), finest = error("800");
  EXPECT_GT(coarse, 0.02) << "it is a rectangle rule";
  EXPECT_LT(fine, coarse / 3.5);
  EXPECT_LT(finest, fine / 1.9);
}

TEST(SubsurfaceTexture, FlatStacksAreTheClosedForm) {
  for (const Material& m : {two_layers(), three_layers()}) {
    const Scene scene = flat_slab(m);
    EXPECT_LT(worst(render(scene, "subsurface_texture", {{"samples_per_pixel", "100"}}), closed_form(scene)), 2e-3);
    EXPECT_LT(worst(render(scene, "subsurface_texture", {{"samples_per_pixel", "20"}}), closed_form(scene)), 1e-2);
  }
}

TEST(SingleScatterExact, FlatStacksAreTheClosedFormAndItKnowsItsError) {
  for (const Material& m : {one_layer(), three_layers()}) {
    const Scene scene = flat_slab(m, 2);
    const Rgb exact = closed_form(scene);
    for (const char* tolerance : {"1e-2", "1e-3"}) {
      const Frame frame = render(scene, "single_scatter_exact", {{"max_relative_error", tolerance}});
      EXPECT_LT(worst(frame, exact), std::stod(tolerance));
      EXPECT_EQ(frame.counters.done.at("points_unconverged"), 0u);
      for (std::size_t i = 0; i < frame.radiance.size(); ++i)
        for (int c = 0; c < 3; ++c)
          EXPECT_LT(std::abs(static_cast<double>(frame.radiance[i][c]) - exact[c]),
                    static_cast<double>(frame.images.at("error")[i][c]) + 3e-6 * exact[c]);
    }
  }
}

TEST(SingleScatterExact, RefractedFlatStacksAreTheClosedForm) {
  Scene scene = flat_slab(three_layers(), 2);
  scene.materials[0].eta = 1.4;
  // Only the first boundary refracts: all layers have one index.
  const Frame frame = render(scene, "single_scatter_exact", {{"refraction", "on"}, {"max_relative_error", "1e-3"}});
  EXPECT_LT(worst(frame, closed_form(scene, 1.4)), 1e-3);
}

// --- curved shapes ----------------------------------------------------------------------------------

struct RmsError {
  double relative = 0;
};
RmsError rms(const Frame& frame, const Frame& exact) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < exact.radiance.size(); ++i) {
    const glm::dvec3 b(exact.radiance[i]), d = glm::dvec3(frame.radiance[i]) - b;
    squares += glm::dot(d, d), norm += glm::dot(b, b);
  }
  return {std::sqrt(squares / norm)};
}

Scene lit_sphere(double radius, const Material& material, int pixels) {
  Scene scene =
      test::layered_scene(make_sphere(radius, 20000), material, 2.4 * radius, pixels, UvProjection::spherical);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.4, -0.3, -0.8)), Rgb(1), 0},
                  PointLight{{2 * radius, 3 * radius, 3 * radius}, Rgb(3 * radius * radius)}};
  return scene;
}

// The planes' error falls with the curvature: a few percent where the surface bends within the light's reach.
TEST(SubsurfaceTexture, ApproachesTheExactMarchAsTheSurfaceFlattens) {
  double before = 0.1;
  for (const double radius : {5.0, 40.0}) {
    const Scene scene = lit_sphere(radius, three_layers(), 5);
    const Frame exact = render(scene, "single_scatter_exact", {{"max_relative_error", "5e-3"}}),
                planar = render(scene, "subsurface_texture");
    const double error = rms(planar, exact).relative;
    EXPECT_LT(error, before) << radius;
    before = error / 1.5;
  }
  EXPECT_LT(before, 0.02);
}

TEST(SubsurfaceTexture, FiftyAndAHundredSamplesAreAlmostIdentical) {
  const Scene scene = lit_sphere(10, test::wavy_layers(), 40);
  const auto difference = [&](const char* far_side, const char* a, const char* b) {
    const auto frame = [&](const char* n) {
      return render(scene, "subsurface_texture", {{"samples_per_pixel", n}, {"far_side", far_side}});
    };
    return rms(frame(a), frame(b)).relative;
  };
  EXPECT_LT(difference("none", "50", "100"), 2e-3);
  EXPECT_LT(difference("none", "50", "100"), difference("none", "10", "100") / 4);
  // Grazing light's way bends within a step, from the tangent plane to the one on the far side: there it is 1/N.
  const double traced = difference("traced", "50", "100");
  EXPECT_LT(traced, 8e-3);
  EXPECT_LT(difference("traced", "200", "400"), traced / 2.5);
}

TEST(SubsurfaceTexture, SkipsChangeNothing) {
  const Scene scene = lit_sphere(10, test::wavy_layers(), 40);
  const Frame with = render(scene, "subsurface_texture"),
              without = render(scene, "subsurface_texture", {{"negligible", "0"}});
  EXPECT_LT(rms(with, without).relative, 2e-4);
  EXPECT_GT(with.counters.skipped.at("march_samples_behind_negligible"), 0u);
  EXPECT_EQ(without.counters.skipped.at("march_samples_behind_negligible"), 0u);
  EXPECT_GT(with.counters.skipped.at("light_paths_from_behind"), 0u);
  EXPECT_GT(with.counters.skipped.at("light_paths_below_layers"), 0u);
}

// A layer that is nowhere thicker than nothing is left out; one that the march never gets to is told.
TEST(SubsurfaceTexture, CountsEmptyAndUnreachedLayers) {
  const std::vector<SubsurfaceLayer> fish = test::fish_layers();
  const Scene empty = flat_slab(test::even_layers(fish, {0.5f, 0.5f, 2})),
              without = flat_slab(test::even_layers({fish[0], fish[2]}, {0.5f, 2})),
              deep = flat_slab(test::even_layers(fish, {9, 9.5f, 10}));
  const Frame a = render(empty, "subsurface_texture"), b = render(without, "subsurface_texture");
  EXPECT_EQ(a.counters.skipped.at("empty_layers"), 1u);
  EXPECT_EQ(a.radiance, b.radiance);
  const Frame c = render(deep, "subsurface_texture");
  EXPECT_EQ(c.counters.skipped.at("layers_nobody_reaches"), 2u);
}

TEST(SubsurfaceTexture, MirroredTextureCoordinatesMirrorTheLayers) {
  Scene scene = lit_sphere(10, test::wavy_layers(), 24);
  Scene mirrored = scene;
  for (glm::vec2& uv : mirrored.objects[0].mesh.uvs) uv.x = 1 - uv.x;
  auto medium = std::make_shared<LayeredMedium>(*scene.materials[0].layers);
  Image image = *medium->depths[0].image;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = medium->depths[0].image->at(image.width - 1 - x, y, c);
  medium->depths[0].image = std::make_shared<const Image>(image);
  mirrored.materials[0].layers = medium;
  EXPECT_LT(rms(render(mirrored, "subsurface_texture"), render(scene, "subsurface_texture")).relative, 1e-4);
}

// Everything that could divide by zero: grazing views, sharp phases, layers of no thickness, coordinates of no area,
// coarse meshes, a clear layer, a light on the surface.
TEST(SubsurfaceTexture, HardCasesStayFiniteAndAreCounted) {
  std::vector<Scene> scenes;
  for (const double g : {-0.9999999, 0.9999999}) {
    Scene scene = lit_sphere(10, one_layer(g < 0 ? Phase::henyey_greenstein : Phase::schlick, g), 24);
    scene.lights.push_back(PointLight{{0, 0, 10}, Rgb(1)});
    scenes.push_back(scene);
  }
  scenes.push_back(lit_sphere(10, test::even_layers(test::fish_layers(), {0, 0, 1e-3f}), 24));
  scenes.push_back(lit_sphere(10, test::even_layers({{Rgb(0), Rgb(0), 0}}, {5}), 24));
  Scene flat_uv = lit_sphere(10, test::wavy_layers(), 24), coarse = flat_uv;
  for (glm::vec2& uv : flat_uv.objects[0].mesh.uvs) uv = glm::vec2(0.5f);
  coarse.objects[0].mesh = make_sphere(10, 20);
  make_texture_coordinates(coarse.objects[0].mesh, UvProjection::planar);
  scenes.push_back(flat_uv), scenes.push_back(coarse);
  for (const Scene& scene : scenes)
    for (const char* march : {"pieces", "paper"}) {
      const Frame frame = render(scene, "subsurface_texture", {{"march", march}, {"reflection", "on"}});
      for (const glm::vec3& l : frame.radiance)
        for (int c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(l[c]) && l[c] >= 0) << l[c];
    }
  EXPECT_GT(render(flat_uv, "subsurface_texture").counters.done.at("vertices_without_tangent_frame"), 1000u);
  EXPECT_EQ(render(coarse, "subsurface_texture").counters.done.at("tangent_planes_in_place_of_fitted"),
            coarse.objects[0].mesh.positions.size());
  Scene grazing = flat_slab(three_layers(), 9);
  grazing.camera.position = {100, 0, 1};
  EXPECT_GT(render(grazing, "subsurface_texture").counters.done.at("grazing_points"), 0u);
}

TEST(SubsurfaceTexture, ReflectionAddsTheSurfacesOwn) {
  Scene scene = lit_sphere(10, test::wavy_layers(), 24);
  scene.materials[0].eta = 1.4;
  const Frame without = render(scene, "subsurface_texture"),
              with = render(scene, "subsurface_texture", {{"reflection", "on"}});
  double most = 0;
  for (std::size_t i = 0; i < with.radiance.size(); ++i) {
    const double more = static_cast<double>(with.radiance[i].g - without.radiance[i].g);
    EXPECT_GE(more, 0);
    most = std::max(most, more);
  }
  EXPECT_GT(most, 0.05);
  scene.materials[0].eta = 1;
  EXPECT_LT(rms(render(scene, "subsurface_texture", {{"reflection", "on"}}), without).relative, 0.02);
}

TEST(LayeredTechniques, SayWhatTheyCannotDo) {
  Scene scene = lit_sphere(10, three_layers(), 4);
  EXPECT_EQ(why_not_applicable(find_technique("subsurface_texture"), scene), "");
  EXPECT_THAT(why_not_applicable(find_technique("hierarchical"), scene), HasSubstr("has layers"));
  scene.lights.push_back(DirectionalLight{{0, 0, -1}, Rgb(1), 2});
  EXPECT_THAT(why_not_applicable(find_technique("single_scatter_exact"), scene), HasSubstr("light 2 has extent"));
  scene.lights.pop_back();
  scene.materials[0] = test::library_material("skin1");
  EXPECT_THAT(why_not_applicable(find_technique("subsurface_texture"), scene), HasSubstr("is homogeneous"));
  scene = lit_sphere(10, three_layers(), 4);
  scene.objects[0].mesh.triangles.pop_back();
  EXPECT_THAT(why_not_applicable(find_technique("single_scatter_exact"), scene), HasSubstr("not closed"));
}

}  // namespace
}  // namespace opaline
