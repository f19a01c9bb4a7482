// path_traced against everything that knows the answer otherwise: Chandrasekhar's H function, the walks of
// model/transport, conservation of radiance. Every |z| < 4 with a fixed seed.
#include "datasets_synthetic/shapes/shapes.h"
#include "model/fresnel.h"
#include "model/profiles/profile.h"
#include "model/transport/h_function.h"
#include "model/transport/walk.h"
#include "render/path_tracing/random.h"
#include "render/render_scene.h"
#include "tests/render/scene_fixture.h"
#include "tests/support/render_fixture.h"

#include <gmock/gmock.h>
#include <tbb/global_control.h>

namespace opaline {
namespace {

using glm::dvec3;
using testing::HasSubstr;

Material medium(double albedo, double g, double eta, double sigma_t = 1) {
  Material m;
  m.sigma_a = Rgb((1 - albedo) * sigma_t);
  m.sigma_s_prime = Rgb(albedo * (1 - g) * sigma_t);
  m.g = g;
  m.eta = eta;
  return m;
}

Scene lit_slab(const Material& m, double thickness, Light light, int triangles = 12) {
  Scene scene = test::make_scene(make_slab({600, 600, thickness}, triangles), m, 1, 2);
  scene.lights = {std::move(light)};
  return scene;
}

/// Irradiance 1 on the slab.
Light beam(double cosine) {
  return DirectionalLight{{-std::sqrt(1 - cosine * cosine), 0, -cosine}, Rgb(1 / cosine), 0};
}

Estimate mean_of(const Frame& frame, int channel = 1) {
  const std::vector<glm::vec3>& variance = frame.images.at("variance");
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < frame.radiance.size(); ++i) {
    sum += static_cast<double>(frame.radiance[i][channel]);
    squares += static_cast<double>(variance[i][channel]);
  }
  const auto n = static_cast<double>(frame.radiance.size());
  return {sum / n, std::sqrt(squares) / n};
}

Frame traced(const Scene& scene, const GBuffer& view, int paths, std::uint64_t seed = 1) {
  EXPECT_EQ(find_technique("path_traced").not_applicable(scene), "");
  SharedSettings settings;
  settings.irradiance.seed = seed;
  const SharedScene shared(scene, settings, false);
  const Technique& technique = find_technique("path_traced");
  return technique.prepare(shared, Settings(technique.settings, {{"paths", std::to_string(paths)}}))->render(view);
}

/// A view of the slab near its middle (not on the diagonal that parts two facets), as seen from `count` directions: pi
/// times the mean radiance is the exitance. The directions are stratified in the squared cosine and uniform in azimuth;
/// `cosine` > 0 takes that one instead.
GBuffer from_all_sides(const Scene& scene, bool bottom, int count, double cosine = 0, std::uint64_t seed = 1) {
  const Mesh& mesh = scene.objects[0].mesh;
  const RayScene rays(scene);
  const float below = bottom ? -1e4f : 1e4f;
  const SurfaceHit hit = rays.closest({40.5f, 0.021f, below}, {0, 0, bottom ? 1 : -1});
  const SurfacePoint p = surface_point(mesh, hit.triangle, hit.u, hit.v);
  GBuffer view;
  view.width = count, view.height = 1;
  RandomStream random{seed};
  for (int i = 0; i < count; ++i) {
    const double c = cosine > 0 ? cosine : std::sqrt((i + random()) / count);
    const dvec3 w = direction_around(dvec3(p.face_normal), c, random());
    view.points.push_back({static_cast<std::uint32_t>(i), 0, hit.triangle, p.position, p.face_normal,
                           static_cast<float>(c), glm::vec3(w)});
  }
  return view;
}

Estimate exitance(const Scene& scene, bool bottom, int directions, std::uint64_t seed = 1, int channel = 1) {
  const Estimate mean = mean_of(traced(scene, from_all_sides(scene, bottom, directions, 0, seed), 2, seed), channel);
  return {pi * mean.value, pi * mean.standard_error};
}

void expect_equal(const Estimate& a, double expected, double expected_error = 0) {
  EXPECT_GT(a.standard_error, 0);
  EXPECT_LT(a.standard_error, 0.04 * std::abs(expected)) << "too noisy to say anything";
  const double z = (a.value - expected) / std::hypot(a.standard_error, expected_error);
  EXPECT_LT(std::abs(z), 4) << a.value << " +- " << a.standard_error << " against " << expected << " +- "
                            << expected_error;
}

// Radiance of an isotropic half space without a boundary: (albedo/4) H(mu0) H(mu)/(mu0 + mu) per unit of E/pi.
TEST(PathTraced, RadianceOfAHalfSpaceIsChandrasekhars) {
  for (const double albedo : {0.5, 0.9})
    for (const double in : {1.0, 0.4})
      for (const double out : {0.9, 0.3}) {
        const Scene scene = lit_slab(medium(albedo, 0, 1), 100, beam(in));
        const double h = chandrasekhar_h(albedo, in) * chandrasekhar_h(albedo, out);
        SCOPED_TRACE(testing::Message() << albedo << " " << in << " " << out);
        expect_equal(mean_of(traced(scene, from_all_sides(scene, false, 1000, out), 4)),
                     albedo / 4 * h / (in + out) / pi);
      }
}

TEST(PathTraced, ExitanceOfAHalfSpaceWithABoundaryIsExact) {
  for (const auto& [albedo, eta, cosine] :
       {std::tuple{0.5, 1.5, 1.0}, {0.9, 1.5, 0.3}, {0.9, 1.3, 1.0}, {0.9, 0.8, 0.8}}) {
    SCOPED_TRACE(testing::Message() << albedo << " " << eta << " " << cosine);
    expect_equal(exitance(lit_slab(medium(albedo, 0, eta), 100, beam(cosine)), false, 2000),
                 half_space_albedo(albedo, eta, cosine).beam_per_incident);
  }
}

/// Scattered light of a slab on both sides against the walks of model/transport.
void expect_slab_of_walks(const Material& m, double thickness, const Light& light, double cosine) {
  Searchlight walks{m.channel(0), m.g, cosine, {}, 1 << 19, 3};
  const SearchlightResult r = walk_slab(walks, thickness);
  const double in = 1 - r.specular;
  const Scene scene = lit_slab(m, thickness, light);
  expect_equal(exitance(scene, false, 4000), in * (r.reflected.value - r.unscattered_reflected.value),
               in * r.reflected.standard_error);
  expect_equal(exitance(scene, true, 4000), in * (r.transmitted.value - r.unscattered_transmitted.value),
               in * r.transmitted.standard_error);
}

// In the thinner ones much of the light is reflected inside before its first scattering.
TEST(PathTraced, SlabsAgreeWithWalks) {
  for (const auto& [thickness, g, eta, cosine] :
       {std::tuple{2.0, 0.0, 1.5, 1.0}, {0.5, 0.75, 1.5, 0.5}, {0.5, -0.4, 2.0, 0.2}, {2.0, 0.75, 1.0, 1.0}}) {
    SCOPED_TRACE(testing::Message() << thickness << " g " << g << " eta " << eta << " cosine " << cosine);
    expect_slab_of_walks(medium(0.9, g, eta), thickness, beam(cosine), cosine);
  }
}

TEST(PathTraced, AFarPointLightLightsASlabAsABeamDoes) {
  constexpr double distance = 1e4, cosine = 0.2;
  const PointLight light{{distance * std::sqrt(1 - cosine * cosine), 0, distance * cosine},
                         Rgb(distance * distance / cosine)};
  expect_slab_of_walks(medium(0.9, 0, 2), 0.5, light, cosine);
}

/// Irradiance 1 within `radius` of the point that is looked at.
Light disk_of_light(double radius) {
  constexpr double distance = 2000;
  ProjectorLight disk;
  disk.position = {40.5, 0.021, distance};
  disk.look_at = {40.5, 0.021, 0};
  disk.intensity = Rgb(distance * distance);
  disk.disk_radius_deg = std::atan(radius / distance) * 180 / pi;
  return disk;
}

// By translation, the exitance in the middle of a wide beam of radius a is what a thin beam sends out within a.
TEST(PathTraced, TheProfileOfABeamIsThatOfWalks) {
  Searchlight walks{{0.1, 0.9, 1.4}, 0, 1, {0, 0.3, 1, 3}, 1 << 20, 5};
  const SearchlightResult r = walk_half_space(walks);
  double inside = 0, error = 0;
  for (const AnnulusEstimate& a : r.reflectance) {
    const double area = pi * (a.outer * a.outer - a.inner * a.inner);
    inside += area * a.exitance.value;
    error = std::hypot(error, area * a.exitance.standard_error);
    SCOPED_TRACE(a.outer);
    expect_equal(exitance(lit_slab(medium(0.9, 0, 1.4), 100, disk_of_light(a.outer)), false, a.outer < 1 ? 6000 : 3000),
                 (1 - r.specular) * inside, (1 - r.specular) * error);
  }
}

// So is the radiance along the normal with the profile of radiance, and not with that of exitance.
TEST(PathTraced, TheRadianceOfABeamAlongTheNormalIsItsProfile) {
  const Material m = medium(0.9, 0, 1.4);
  const double entering = fresnel_transmittance(1.0, m.eta);
  const double lobe = entering / (pi * exit_lobe_normalisation(m.eta, ExitLobe::normalised));
  double furthest = 0;
  for (const double radius : {0.3, 1.0, 3.0}) {
    SCOPED_TRACE(radius);
    const Scene scene = lit_slab(m, 100, disk_of_light(radius));
    const Estimate traced_radiance = mean_of(traced(scene, from_all_sides(scene, false, 1, 1), 12000));
    const auto drawn = [&](const char* name) {
      return lobe * entering * find_profile(name)->make(m.channel(1))->cumulative(radius);
    };
    expect_equal(traced_radiance, drawn("transport_radiance"));
    const double off = std::abs(traced_radiance.value - drawn("transport_table")) / traced_radiance.standard_error;
    furthest = std::max(furthest, off);
  }
  EXPECT_GT(furthest, 8);
}

// --- conservation of radiance -----------------------------------------------------------------------

Light constant_environment(float radiance) {
  auto image = std::make_shared<Image>(8, 4, std::vector<std::string>{"Y"});
  std::fill(image->data.begin(), image->data.end(), radiance);
  return EnvironmentLight{"", image, Rgb(1)};
}

/// Mean radiance of a convex object that absorbs nothing under radiance 1 from everywhere, over the mean of F_t(w_o).
/// It is 1 whatever the shape, eta and g.
Estimate furnace(const Mesh& mesh, const Material& m, int paths, int channel) {
  Scene scene = test::make_scene(mesh, m, 2.6, 16);
  scene.camera.position = {10, 7, 20};
  scene.lights = {constant_environment(1)};
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  double through = 0;
  for (const VisiblePoint& p : view.points) {
    const glm::vec3 normal = surface_point(mesh, p.triangle, 0.3f, 0.3f).face_normal;
    through += fresnel_transmittance(static_cast<double>(glm::dot(normal, p.w_o)), m.eta);
  }
  through /= static_cast<double>(view.points.size());
  const Estimate mean = mean_of(traced(scene, view, paths), channel);
  return {mean.value / through, mean.standard_error / through};
}

TEST(PathTraced, AWhiteObjectInAWhiteRoomIsInvisible) {
  Material coloured = medium(1, 0.6, 1.5, 1.5);
  coloured.sigma_s_prime = {0.1, 0.6, 2};
  for (const auto& [name, mesh] : {std::pair{"sphere", make_sphere(1, 80)}, {"box", make_slab({1.6, 1.4, 0.7}, 40)}}) {
    SCOPED_TRACE(name);
    for (const int channel : {0, 2}) expect_equal(furnace(mesh, coloured, 64, channel), 1);
    expect_equal(furnace(mesh, medium(1, 0, 1.5, 0.4), 48, 1), 1);
    expect_equal(furnace(mesh, medium(1, -0.5, 0.75, 2), 48, 1), 1);
  }
}

// The same with two disks of half-angle 90 degrees, whose light comes in three ways: refracted, reflected inside
// before its first scattering, and not scattered at all.
TEST(PathTraced, AWhiteSlabBetweenTwoWhiteDisksIsInvisible) {
  for (const double thickness : {0.3, 2.0}) {
    Scene scene = lit_slab(medium(1, 0, 1.5), thickness, DirectionalLight{{0, 0, -1}, Rgb(pi), 90});
    scene.lights.emplace_back(DirectionalLight{{0, 0, 1}, Rgb(pi), 90});
    expect_equal(exitance(scene, false, 12000), pi * diffuse_transmittance_external(1.5));
  }
}

TEST(PathTraced, AHalfSpaceUnderAWhiteDiskIsExact) {
  const Scene scene = lit_slab(medium(0.9, 0, 1.5), 100, DirectionalLight{{0, 0, -1}, Rgb(1), 90});
  expect_equal(exitance(scene, false, 3000), half_space_albedo(0.9, 1.5).white_per_incident);
}

// --- one path for three channels --------------------------------------------------------------------

TEST(PathTraced, ChannelsAreThoseOfTheGreyMediaApart) {
  Material coloured = medium(0.9, 0, 1.3);
  coloured.sigma_a = {0.05, 0.3, 0.05};
  coloured.sigma_s_prime = {0.5, 1, 3};
  const Scene scene = lit_slab(coloured, 3, beam(0.7));
  for (int c = 0; c < 3; ++c) {
    Material grey = coloured;
    grey.sigma_a = Rgb(coloured.sigma_a[c]);
    grey.sigma_s_prime = Rgb(coloured.sigma_s_prime[c]);
    const Estimate alone = exitance(lit_slab(grey, 3, beam(0.7)), false, 2500, 5);
    expect_equal(exitance(scene, false, 2500, 1, c), alone.value, alone.standard_error);
  }
}

TEST(PathTraced, EqualChannelsShareTheirWalksAndAreCounted) {
  const Scene scene = lit_slab(medium(0.5, 0, 1.3), 3, beam(1));
  const Frame frame = traced(scene, from_all_sides(scene, false, 50), 4);
  EXPECT_EQ(frame.counters.done.at("paths"), 200u);
  EXPECT_EQ(frame.counters.done.at("walks"), 200u);
  EXPECT_EQ(frame.counters.skipped.at("equal_channel_walks"), 400u);
  EXPECT_GT(frame.counters.done.at("scatterings"), 100u);
  EXPECT_EQ(frame.counters.skipped.at("walks_lost_at_edges"), 0u);
  for (const glm::vec3& r : frame.radiance) EXPECT_TRUE(r.x == r.y && r.y == r.z);
}

// --- the variance, the seed, the threads ------------------------------------------------------------

// Over many seeds the mean of (value - mean of all)^2 is the mean of the reported variances.
TEST(PathTraced, TheVarianceImageIsTheVariance) {
  Scene scene = test::make_scene(make_sphere(1, 320), medium(0.8, 0.3, 1.3, 2), 2.4, 6);
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  constexpr int seeds = 60;
  std::vector<Frame> frames;
  for (int seed = 0; seed < seeds; ++seed)
    frames.push_back(traced(scene, view, 16, 100 + static_cast<std::uint64_t>(seed)));
  double sum = 0, squares = 0;  // per pixel: spread over seeds / reported - 1
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    double mean = 0, reported = 0, spread = 0;
    for (const Frame& f : frames) {
      mean += static_cast<double>(f.radiance[i].g) / seeds;
      reported += static_cast<double>(f.images.at("variance")[i].g) / seeds;
    }
    for (const Frame& f : frames) spread += std::pow(static_cast<double>(f.radiance[i].g) - mean, 2) / (seeds - 1);
    const double x = spread / reported - 1;
    sum += x, squares += x * x;
  }
  const auto n = static_cast<double>(view.points.size());
  const double error = std::sqrt((squares / n - sum / n * sum / n) / n);
  EXPECT_LT(error, 0.06);
  EXPECT_LT(std::abs(sum / n) / error, 4) << sum / n << " +- " << error;
}

TEST(PathTraced, TheSamePictureForAnyNumberOfThreads) {
  const Scene scene = test::make_scene(make_sphere(5, 320), test::library_material("skin1"), 11, 12);
  const GBuffer view = make_gbuffer(scene, RayScene(scene));
  const Frame many = traced(scene, view, 4);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Frame single = traced(scene, view, 4);
  EXPECT_EQ(many.radiance, single.radiance);
  EXPECT_EQ(many.images.at("variance"), single.images.at("variance"));
  EXPECT_EQ(many.counters.done, single.counters.done);
  EXPECT_NE(many.radiance, traced(scene, view, 4, 2).radiance);
}

// --- bad input --------------------------------------------------------------------------------------

TEST(PathTraced, RefusesBadSettingsAndOpenMeshes) {
  const Technique& technique = find_technique("path_traced");
  for (const char* bad : {"1", "2.5", "many", "1e9"})
    EXPECT_THAT(test::message_of([&] {
                  Settings(technique.settings, {{"paths", bad}});
                }),
                HasSubstr(std::string("'") + bad + "' is not a whole number from 2 to 1"));
  Scene scene = test::make_scene(make_sphere(5, 80), test::library_material("skin1"), 11, 4);
  scene.objects[0].mesh.triangles.pop_back();
  RenderOptions options;
  options.technique = "path_traced";
  EXPECT_THAT(test::message_of([&] { render_scene(scene, options); }),
              testing::AllOf(HasSubstr("path_traced"), HasSubstr("'object'"), HasSubstr("not closed")));
}

TEST(PathTraced, RenderSceneMakesAVarianceLayerAndNoIrradiance) {
  const Scene scene = test::make_scene(make_sphere(5, 80), test::library_material("skin1"), 11, 6);
  RenderOptions options;
  options.technique = "path_traced";
  options.settings = {{"paths", "3"}};
  const RenderResult result = render_scene(scene, options);
  ASSERT_EQ(result.layers.count("variance"), 1u);
  EXPECT_GT(result.layers.at("variance").at(3, 3, 0), 0);
  EXPECT_EQ(result.counters.done.count("surface_cells"), 0u);
  EXPECT_EQ(result.counters.skipped.at("surface_cells"), options.shared.samples);
}

}  // namespace
}  // namespace opaline
