// Image-space importance sampling: its sample sets, its views, and the estimate against the reference.
#include "render/image_space/image_space.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "model/fresnel.h"
#include "model/simd.h"
#include "render/image_space/light_views.h"
#include "render/image_space/sample_gather.h"
#include "render/image_space/shadow_edges.h"
#include "render/visibility/convexity.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>

namespace opaline {
namespace {

using testing::HasSubstr;

// --- sample sets ------------------------------------------------------------------------------------

ChannelProfiles profiles_of(const std::string& profile, const Material& material) {
  return ChannelProfiles(*find_profile(profile), material, 100);
}

Material grey(double sigma_a, double sigma_s_prime) {
  Material material;
  material.sigma_a = Rgb(sigma_a), material.sigma_s_prime = Rgb(sigma_s_prime), material.eta = 1.3;
  return material;
}

struct Draw {
  double r, turn;
};

/// The first sample of each of many sets: independent draws.
std::vector<Draw> first_samples(const ChannelProfiles& profiles, double uniform_share, std::size_t which) {
  std::vector<Draw> draws;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SampleSets sets = make_sample_sets(profiles, {8, 16, uniform_share, 3.0, seed});
    for (const SampleSet& set : sets.sets) {
      const double u = static_cast<double>(set.u[which]), v = static_cast<double>(set.v[which]);
      draws.push_back({std::hypot(u, v), std::atan2(v, u) / (2 * pi) + 0.5});
    }
  }
  return draws;
}

/// (chi^2 - k) / sqrt(2 k) over 32 bins that numbers uniform in [0, 1) fill evenly.
double chi_squared_z(const std::vector<double>& uniform) {
  constexpr int bins = 32;
  double count[bins] = {}, chi = 0;
  for (const double x : uniform) ++count[std::min(static_cast<int>(x * bins), bins - 1)];
  const double expected = static_cast<double>(uniform.size()) / bins;
  for (const double n : count) chi += (n - expected) * (n - expected) / expected;
  return (chi - (bins - 1)) / std::sqrt(2.0 * (bins - 1));
}

class SampleDistances : public testing::TestWithParam<std::string> {};

TEST_P(SampleDistances, FollowTheProfileByChiSquared) {
  const ChannelProfiles profiles = profiles_of(GetParam(), grey(0.05, 1));
  std::vector<double> shares, turns;
  for (const Draw& draw : first_samples(profiles, 0, 0)) {
    shares.push_back(profiles.profile(0).cumulative(draw.r) / profiles.profile(0).total());
    turns.push_back(draw.turn);
  }
  EXPECT_LT(std::abs(chi_squared_z(shares)), 4);
  EXPECT_LT(std::abs(chi_squared_z(turns)), 4);
}

INSTANTIATE_TEST_SUITE_P(Profiles, SampleDistances, testing::Values("standard_dipole", "normalised_diffusion"),
                         [](const auto& row) { return row.param; });

TEST(SampleDistances, OfTheUniformSetCoverTheDisc) {
  const ChannelProfiles profiles = profiles_of("standard_dipole", grey(0.05, 1));
  std::vector<double> shares;
  for (const Draw& draw : first_samples(profiles, 0.5, 4)) shares.push_back(draw.r * draw.r / 9.0);  // R' = 3
  EXPECT_LT(std::abs(chi_squared_z(shares)), 4);
}

// Each channel's shares sum to its total reflectance: weights and densities fit each other, with and without
// the uniform set. (Every set is shifted by itself, so the sums of the sets are independent.)
TEST(SampleSets, SumToTheReflectanceOfEveryChannel) {
  const ChannelProfiles profiles = profiles_of("standard_dipole", test::library_material("skin1"));
  ASSERT_EQ(profiles.distinct(), 3);
  for (const double uniform_share : {0.0, 0.25}) {
    double sum[3] = {}, squares[3] = {}, n = 0;
    for (std::uint64_t seed = 1; seed <= 6; ++seed)
      for (const SampleSet& set : make_sample_sets(profiles, {64, 16, uniform_share, 4.0, seed}).sets) {
        ++n;
        for (std::size_t t = 0; t < 3; ++t) {
          double total = 0;
          for (const float share : set.share[t]) total += static_cast<double>(share);
          sum[t] += total, squares[t] += total * total;
        }
      }
    for (int c = 0; c < 3; ++c) {
      const int t = profiles.sum().table_of[c];
      const double mean = sum[t] / n, error = std::sqrt((squares[t] / n - mean * mean) / n);
      EXPECT_LT(error, 4e-3 * mean);
      EXPECT_LT(std::abs(mean - profiles.profile(c).total()), 4 * error) << "channel " << c << ", " << uniform_share;
    }
  }
}

TEST(SampleSets, HoldAsManySamplesAsAskedPaddedToVectors) {
  const ChannelProfiles profiles = profiles_of("standard_dipole", test::library_material("skin1"));
  const SampleSets sets = make_sample_sets(profiles, {61, 3, 0.25, 4.0, 1});
  ASSERT_EQ(sets.sets.size(), 9u);
  for (const SampleSet& set : sets.sets) {
    EXPECT_EQ(set.count, 61u);
    EXPECT_EQ(set.weight.size(), 64u);
    for (std::size_t i = 61; i < 64; ++i) EXPECT_EQ(set.weight[i], 0);
  }
  EXPECT_EQ(&sets.of_pixel(4, 5), &sets.sets[2 * 3 + 1]);
  EXPECT_NE(sets.sets[0].u, sets.sets[1].u);
}

TEST(DiscRadius, HoldsTheShareOfTheWidestChannel) {
  const ChannelProfiles profiles = profiles_of("standard_dipole", test::library_material("skin1"));
  const double r = disc_radius(profiles, 0.9, 100);
  double least = 1;
  for (int c = 0; c < 3; ++c) least = std::min(least, profiles.profile(c).cumulative(r) / profiles.profile(c).total());
  EXPECT_NEAR(least, 0.9, 1e-6);
  EXPECT_EQ(disc_radius(profiles, 0.9, 0.5), 0.5);
}

// --- shadows and edges ------------------------------------------------------------------------------

TEST(Convexity, KnowsConvexShapes) {
  EXPECT_TRUE(is_convex(make_sphere(10, 500)));
  EXPECT_TRUE(is_convex(make_slab({10, 20, 5}, 500)));
  EXPECT_FALSE(is_convex(make_torus(5, 2, 500)));
  Mesh two = make_sphere(3, 100), inside_out = make_sphere(3, 100), open = make_sphere(3, 100);
  const auto vertices = static_cast<std::uint32_t>(two.positions.size());
  for (std::uint32_t i = 0; i < vertices; ++i) two.positions.push_back(two.positions[i] + glm::vec3(20, 0, 0));
  for (std::size_t i = 0, n = two.triangles.size(); i < n; ++i) two.triangles.push_back(two.triangles[i] + vertices);
  two.normals.clear();
  EXPECT_FALSE(is_convex(two)) << "each casts a shadow on the other";
  for (glm::uvec3& t : inside_out.triangles) std::swap(t.x, t.y);
  EXPECT_FALSE(is_convex(inside_out));
  open.triangles.pop_back();
  EXPECT_FALSE(is_convex(open));
}

TEST(ViewIrradiance, OfAConvexObjectNeedsNoShadowRay) {
  const Scene scene = test::make_scene(make_sphere(10, 2000), test::library_material("skin1"), 22, 40);
  ASSERT_TRUE(nothing_in_shadow(scene));
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  Counters with, without;
  const ViewIrradiance a = view_irradiance(scene, rays, view, {}, false, with),
                       b = view_irradiance(scene, rays, view, {}, true, without);
  EXPECT_EQ(a.values, b.values);
  EXPECT_EQ(without.done.at("shadow_rays"), 0u);
  EXPECT_EQ(without.skipped.at("shadow_rays_nothing_in_shadow"), with.done.at("shadow_rays"));
}

/// An image whose left half is white.
std::shared_ptr<const Image> half_white() {
  Image image(64, 64, {"Y"});
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 32; ++x) image.at(x, y, 0) = 1;
  return std::make_shared<const Image>(image);
}

/// A slab under a projector that covers 20 x 20 mm of it, all of which an orthographic camera sees head on.
Scene projected_slab(std::shared_ptr<const Image> image, int pixels,
                     Material material = test::library_material("skin1")) {
  Scene scene = test::make_scene(make_slab({60, 60, 12}, 400), std::move(material), 30, pixels);
  ProjectorLight light;
  light.position = {0, 0, 200};
  light.fov_y_deg = 2 * std::atan(10.0 / 200) * 180 / pi;
  light.intensity = Rgb(200 * 200);
  light.image = std::move(image);
  scene.lights = {light};
  return scene;
}

TEST(LightEdges, AreMarkedWithinTheDiscAndNowhereElse) {
  const Scene scene = projected_slab(half_white(), 60);  // 2 pixels/mm; edges at x = 0 and round the lit half
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  Counters counters;
  const ViewIrradiance irradiance = view_irradiance(scene, rays, view, {}, true, counters);
  const std::vector<std::uint8_t> near = near_light_edges(view, irradiance, 2.0);
  for (std::size_t i = 0; i < near.size(); ++i) {
    const glm::vec3 p = view.points[i].position;
    if (std::abs(p.y) > 7) continue;
    const float distance = std::min(std::abs(p.x), std::abs(p.x + 10));
    if (distance < 1.5f) {
      EXPECT_EQ(near[i], 1) << p.x << " " << p.y;
    }
    if (distance > 3.5f) {
      EXPECT_EQ(near[i], 0) << p.x << " " << p.y;
    }
  }
}

TEST(LightViews, SeeTheWholeSceneFromTheLight) {
  Scene scene = test::make_scene(make_sphere(10, 2000), test::library_material("skin1"), 22, 24);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(1, -2, 0.5)), Rgb(1), 0}, PointLight{{0, 60, 0}, Rgb(1)},
                  PointLight{{0, 11, 0}, Rgb(1)}};
  const RayScene rays(scene);
  Counters counters;
  const std::vector<GBuffer> views = light_views(scene, rays, 64, counters);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(counters.skipped.at("lights_without_a_view"), 1u) << "a light that near sees too much at once";
  const double area = 17.32 * 17.32 * 4 / pi * 1.01 * 1.01;  // film over disc: the ball round the box is larger
  EXPECT_NEAR(static_cast<double>(views[0].points.size()), 64 * 64 * 100 / area, 64 * 64 * 100 / area * 0.05);
  for (const GBuffer& view : views)
    for (const VisiblePoint& p : view.points) {
      const int x = static_cast<int>(p.pixel) % 64, y = static_cast<int>(p.pixel) / 64;
      ASSERT_TRUE(x > 0 && y > 0 && x < 63 && y < 63) << "the object touches the film's edge";
      EXPECT_GT(p.cos_o, 0);
    }
}

// --- the estimate -----------------------------------------------------------------------------------

const Technique& sampling() { return find_technique("image_space_sampling"); }

using Given = std::map<std::string, std::string>;

Frame render(const SharedScene& shared, const Given& given) {
  return sampling().prepare(shared, Settings(sampling().settings, given))->render(shared.view);
}

Frame reference(const Scene& scene, std::size_t samples, double tolerance) {
  const SharedScene shared(scene, {samples, {}});
  const Technique& technique = find_technique("hierarchical");
  const Settings settings(technique.settings, {{"max_relative_error", std::to_string(tolerance)}});
  return technique.prepare(shared, settings)->render(shared.view);
}

/// A smooth pattern of light: two crossed waves with a soft border.
std::shared_ptr<const Image> waves() {
  Image image(128, 128, {"Y"});
  for (int y = 0; y < 128; ++y)
    for (int x = 0; x < 128; ++x) {
      const double u = (x - 63.5) / 64, v = (y - 63.5) / 64;
      const double border = std::max(0.0, 1 - u * u) * std::max(0.0, 1 - v * v);
      image.at(x, y, 0) = static_cast<float>(border * (1 + 0.8 * std::sin(5 * u) * std::cos(4 * v)));
    }
  return std::make_shared<const Image>(image);
}

struct Agreement {
  double mean, error;  ///< of the relative difference over seeds, and its standard error
};

/// Mean over the points where the reference is in [low, high] times its largest value.
Agreement agreement(const std::vector<Frame>& frames, const Frame& exact, int channel, float low, float high) {
  float largest = 0;
  for (const glm::vec3& b : exact.exitance) largest = std::max(largest, b[channel]);
  double sum = 0, squares = 0;
  for (const Frame& frame : frames) {
    double difference = 0, total = 0;
    for (std::size_t i = 0; i < exact.exitance.size(); ++i) {
      const float b = exact.exitance[i][channel];
      if (b < low * largest || b > high * largest) continue;
      difference += static_cast<double>(frame.exitance[i][channel] - b);
      total += static_cast<double>(b);
    }
    sum += difference / total, squares += difference * difference / (total * total);
  }
  const double n = static_cast<double>(frames.size()), mean = sum / n;
  return {mean, std::sqrt(std::max(squares / n - mean * mean, 0.0) / (n - 1))};
}

struct Estimate {
  std::string name;
  bool oblique;
  Given given;
};
std::ostream& operator<<(std::ostream& out, const Estimate& e) { return out << e.name; }

class OnAFlatSlab : public testing::TestWithParam<Estimate> {};

Scene waves_on_a_slab(bool oblique) {
  Scene scene = projected_slab(waves(), 220);
  if (oblique) scene.camera = {Camera::Type::perspective, {0, -60, 60}, {0, 0, 0}, {0, 1, 0}, 25, 0};
  return scene;
}

// The estimator's assumption holds there: all lit surface is seen. What is left beside the noise, 5e-4, is the width
// of a pixel of the irradiance image (2e-3 where it is dim with pixels twice as wide, against a finer reference).
TEST_P(OnAFlatSlab, TheMeanOverSeedsIsTheReference) {
  const bool oblique = GetParam().oblique;
  const Scene scene = waves_on_a_slab(oblique);
  static const Frame references[2] = {reference(waves_on_a_slab(false), 30000, 2e-4),
                                      reference(waves_on_a_slab(true), 30000, 2e-4)};
  const Frame& exact = references[oblique];
  std::vector<Frame> frames;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const SharedScene shared(scene, {1, {.seed = seed}}, false);
    Given given = GetParam().given;
    given["samples_per_pixel"] = "128", given["pattern"] = "16";
    frames.push_back(render(shared, given));
  }
  for (int c = 0; c < 3; ++c)
    for (const auto& [low, high] : {std::pair(0.1f, 1.0f), std::pair(0.5f, 1.0f), std::pair(0.06f, 0.3f)}) {
      const Agreement a = agreement(frames, exact, c, low, high);
      EXPECT_LT(a.error, 1e-3) << "channel " << c << " from " << low;
      EXPECT_LT(std::abs(a.mean), 3 * a.error + 5e-4) << "channel " << c << " from " << low << " +- " << a.error;
    }
}

INSTANTIATE_TEST_SUITE_P(Settings, OnAFlatSlab,
                         testing::Values(Estimate{"importance", false, {{"uniform", "never"}}},
                                         Estimate{"combined", false, {{"uniform", "always"}}},
                                         Estimate{"oblique", true, {{"uniform", "near_edges"}}},
                                         Estimate{"oblique_on_the_tangent_plane", true, {{"min_plane_cosine", "0"}}},
                                         Estimate{"two_views", false, {{"views", "camera+light"}}},
                                         Estimate{"two_oblique_views", true, {{"views", "camera+light"}}}),
                         [](const auto& row) { return row.param.name; });

// Evenly lit, as far as one sees: every valid sample finds the same light, so the sum of those is exact.
TEST(ImageSpaceSampling, NormalisedByValidSamplesIsExactUnderEvenLight) {
  Scene scene = test::make_scene(make_slab({100, 100, 20}, 100), test::library_material("skin1"), 10, 24);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  const SharedScene shared(scene, {1, {}}, false);
  const double entering = fresnel_transmittance(1.0, scene.materials[0].eta);
  const ChannelProfiles profiles = profiles_of("standard_dipole", scene.materials[0]);
  for (const std::string jacobian : {"on", "off"}) {
    const Frame valid = render(shared, {{"normalise", "valid"}, {"jacobian", jacobian}}), all = render(shared, {});
    for (std::size_t i = 0; i < valid.exitance.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        const double exact = entering * profiles.profile(c).total();
        EXPECT_NEAR(static_cast<double>(valid.exitance[i][c]), exact, 2e-4 * exact);
        EXPECT_LT(static_cast<double>(all.exitance[i][c]), 1.2 * exact);
      }
    EXPECT_LT(all.exitance[0].r, 0.7f * valid.exitance[0].r) << "in a corner of the film three quarters are missed";
  }
}

// The slab is thinner than a pixel is wide: the side that is lit must not be taken for the one that is seen.
TEST(ImageSpaceSampling, SeesLightFromBehindOnlyWithTheLightsView) {
  Scene scene = test::make_scene(make_slab({60, 60, 0.4}, 400), test::library_material("skin1"), 12, 24);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.3, 0, 1)), Rgb(1), 0}};
  const Frame exact = reference(scene, 20000, 1e-3);
  const SharedScene shared(scene, {1, {}}, false);
  const Frame one = render(shared, {}), two = render(shared, {{"views", "camera+light"}, {"samples_per_pixel", "512"}});
  for (int c = 0; c < 3; ++c) {
    const test::Difference d = test::relative_difference(two.exitance, exact.exitance, c, 1e-6f);
    EXPECT_EQ(d.count, exact.exitance.size());
    EXPECT_LT(std::abs(d.mean), 5e-3) << c;
    EXPECT_LT(d.rms, 0.05) << c;
  }
  for (const glm::vec3& b : one.exitance) EXPECT_EQ(b, glm::vec3(0));
}

TEST(ImageSpaceSampling, ErrorFallsWithTheSamples) {
  const Scene scene = projected_slab(waves(), 60);
  const Frame exact = reference(scene, 20000, 1e-4);
  const SharedScene shared(scene, {1, {}}, false);
  const auto rms = [&](const std::string& n) {
    return test::relative_difference(render(shared, {{"samples_per_pixel", n}}).exitance, exact.exitance, 1, 0.05f).rms;
  };
  const double few = rms("16"), many = rms("256");
  EXPECT_LT(many, few / 3.5) << "16 times as many: a quarter by the square root";
  EXPECT_LT(many, 0.03);
}

TEST(ImageSpaceSampling, IsTheSameForAnyNumberOfThreadsAndDependsOnTheSeed) {
  const Scene scene = projected_slab(half_white(), 40);
  const SharedScene shared(scene, {1, {}}, false), other(scene, {1, {.seed = 2}}, false);
  const Frame frame = render(shared, {});
  EXPECT_NE(frame.exitance, render(other, {}).exitance);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  EXPECT_EQ(frame.exitance, render(shared, {}).exitance);
}

TEST(ImageSpaceSampling, IsTheSameOnEveryVectorUnit) {
  Scene scene = projected_slab(waves(), 40);
  scene.camera = {Camera::Type::perspective, {0, -60, 60}, {0, 0, 0}, {0, 1, 0}, 25, 0};
  const SharedScene shared(scene, {1, {}}, false);
  const Frame best = render(shared, {{"views", "camera+light"}});
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    const Frame frame = render(shared, {{"views", "camera+light"}});
    EXPECT_LT(test::relative_difference(frame.exitance, best.exitance, 0, 0.05f).rms, 1e-3) << target;
  }
  limit_simd_target("");
}

TEST(ImageSpaceSampling, CountsWhatItSkips) {
  const Scene scene = projected_slab(half_white(), 40, grey(0.2, 2));
  const SharedScene shared(scene, {1, {}}, false);
  const Counters c = render(shared, {}).counters;
  const std::uint64_t points = shared.view.points.size(), samples = 64 * points;
  EXPECT_EQ(c.done.at("samples"), samples);
  EXPECT_EQ(c.done.at("channels"), 1u);
  EXPECT_EQ(c.skipped.at("equal_channels"), 2u);
  EXPECT_GT(c.skipped.at("uniform_sets_far_from_shadow_edges"), 0u);
  EXPECT_EQ(c.skipped.at("uniform_sets_far_from_shadow_edges") + c.done.at("points_with_uniform_set"), points);
  EXPECT_GT(c.skipped.at("samples_unlit"), samples / 3);
  EXPECT_LT(c.done.at("samples_looked_up"), samples);
  EXPECT_GT(c.skipped.at("samples_off_object"), 0u);
  EXPECT_EQ(c.done.at("shadow_rays"), 0u);
  EXPECT_EQ(shared.counters.skipped.at("surface_cells"), 1u);
}

TEST(ImageSpaceSampling, RejectsSettingsWithoutAMeaning) {
  const auto message = [](const Given& given) {
    return test::message_of([&] { read_image_space_settings(Settings(sampling().settings, given)); });
  };
  EXPECT_THAT(message({{"samples_per_pixel", "7"}}),
              HasSubstr("--set samples_per_pixel: '7' is not a number from 8 to 1024"));
  EXPECT_THAT(message({{"samples_per_pixel", "64.5"}}), HasSubstr("'64.5' is not a whole number"));
  EXPECT_THAT(message({{"pattern", "0"}}), HasSubstr("from 1 to 16"));
  EXPECT_THAT(message({{"views", "light"}}), HasSubstr("is not one of camera, camera+light"));
  EXPECT_THAT(message({{"views", "camera+light"}, {"normalise", "valid"}}),
              HasSubstr("counts the samples of one view"));
}

TEST(ImageSpaceSampling, TakesAtMostFifteenLightViews) {
  Scene scene = projected_slab(half_white(), 8);
  scene.lights.resize(16, scene.lights[0]);
  const SharedScene shared(scene, {1, {}}, false);
  EXPECT_THAT(test::message_of([&] {
                render(shared, {{"views", "camera+light"}, {"light_view_pixels", "16"}});
              }),
              HasSubstr("at most 15 lights"));
}

}  // namespace
}  // namespace opaline
