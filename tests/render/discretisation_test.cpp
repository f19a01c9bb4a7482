// The estimate of what cells leave out against the truth: the same object cut much finer.
#include "render/irradiance/discretisation.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

namespace opaline {
namespace {

struct Subject {
  const char* name;
  Mesh (*mesh)();
  std::vector<Light> lights;
  double height = 22;  ///< of the picture [mm]
};

Light side_light() { return DirectionalLight{glm::normalize(glm::dvec3(0.8, -0.3, -0.5)), Rgb(1), 0}; }

/// A disk of light of 1 mm radius on a slab 20 mm wide: its edge cuts cells.
Light beam() {
  ProjectorLight light;
  light.position = {0, 0, 50};
  light.look_at = {0, 0, 0};
  light.up = {0, 1, 0};
  light.intensity = Rgb(2500);
  light.disk_radius_deg = std::atan(1.0 / 50) * 180 / pi;
  return light;
}

Mesh sphere() { return make_sphere(10, 500); }
Mesh torus() { return make_torus(8, 3, 500); }
Mesh plate() { return make_slab({20, 20, 2}, 12); }

struct Cut {
  Scene scene;
  RayScene rays;
  ChannelProfiles profiles;
  std::vector<glm::vec3> points;
  Counters counters{};

  Cut(const Subject& subject, const std::string& material)
      : scene(make(subject, material)),
        rays(scene),
        profiles(*find_profile("standard_dipole"), scene.materials[0], 1.01 * diameter(scene.objects[0].mesh)) {
    for (const VisiblePoint& p : make_gbuffer(scene, rays).points) points.push_back(p.position);
  }
  static Scene make(const Subject& subject, const std::string& material) {
    Scene scene = test::make_scene(subject.mesh(), test::library_material(material), subject.height, 24);
    scene.lights = subject.lights;
    return scene;
  }

  SurfaceCells cells(std::size_t count) {
    std::vector<SurfaceCells> all{make_surface_cells(scene.objects[0].mesh, count)};
    return refine_at_light_edges(scene, rays, std::move(all), {}, counters)[0];
  }
  Discretisation discretise(std::size_t count, double tolerance, std::size_t most = 4'000'000) {
    const SurfaceCells coarse = cells(count);
    const IrradianceField field = object_irradiance(scene, rays, 0, coarse, 0, {}, counters);
    return opaline::discretise(scene, rays, 0, coarse, field, profiles, {}, {tolerance, most, 8}, counters);
  }
  std::vector<glm::vec3> exitance(const Discretisation& d) {
    return gather_exitance(d.tree, d.cells, profiles, d.irradiance.colour, points, test::by_error(1e-4), counters);
  }
};

/// RMS over RMS, of the channel that is worst.
double relative_rms(const std::vector<glm::vec3>& a, const std::vector<glm::vec3>& b) {
  double worst = 0;
  for (int c = 0; c < 3; ++c) {
    double error = 0, norm = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      const double d = static_cast<double>(a[i][c] - b[i][c]);
      error += d * d, norm += static_cast<double>(b[i][c] * b[i][c]);
    }
    worst = std::max(worst, std::sqrt(error / norm));
  }
  return worst;
}

std::vector<Subject> subjects() {
  return {{"sphere", sphere, {side_light()}}, {"torus", torus, {side_light()}}, {"beam", plate, {beam()}, 6}};
}

class DiscretisationOf : public testing::TestWithParam<std::tuple<int, std::string>> {};

// Cells so coarse that they are wrong are refined until the picture is within the tolerance. The truth is the same
// object cut evenly into 120000 cells, wrong by 2e-4 to 5e-4: nothing the estimate has a part in.
TEST_P(DiscretisationOf, ReachesItsToleranceFromCoarseCells) {
  const auto& [which, material] = GetParam();
  Cut cut(subjects()[static_cast<std::size_t>(which)], material);
  const std::vector<glm::vec3> exact = cut.exitance(cut.discretise(120000, 1));
  for (const double tolerance : {1e-2, 4e-3, 2e-3}) {
    const Discretisation d = cut.discretise(300, tolerance);
    EXPECT_LE(d.error, tolerance);
    const double error = relative_rms(cut.exitance(d), exact);
    EXPECT_LT(error, 1.25 * tolerance) << d.cells.size() << " cells, estimated " << d.error;
    EXPECT_LT(error, 1.2 * d.error) << "the estimate is too small";
    EXPECT_GT(error, 0.03 * d.error) << "the estimate is far too large";
    EXPECT_EQ(d.irradiance.values.size(), d.cells.size());
  }
}

INSTANTIATE_TEST_SUITE_P(ShapesAndMaterials, DiscretisationOf,
                         testing::Combine(testing::Values(0, 1, 2), testing::Values("skin1", "ketchup")),
                         [](const auto& row) {
                           return subjects()[static_cast<std::size_t>(std::get<0>(row.param))].name + std::string("_") +
                                  std::get<1>(row.param);
                         });

TEST(Discretisation, CoversTheSurfaceOnceAndKeepsTheFlux) {
  Cut cut(subjects()[1], "marble");
  const Discretisation coarse = cut.discretise(300, 1), fine = cut.discretise(300, 2e-3);
  EXPECT_EQ(coarse.rounds, 0);
  EXPECT_GT(fine.rounds, 0);
  EXPECT_EQ((fine.cells.size() - coarse.cells.size()) % 3, 0u);
  double area = 0, same = 0;
  for (const SurfaceCell& c : fine.cells) area += static_cast<double>(cell_area(c));
  for (const SurfaceCell& c : coarse.cells) same += static_cast<double>(cell_area(c));
  EXPECT_NEAR(area, same, 1e-5 * same);
  EXPECT_NEAR(fine.tree.total_mass[0], coarse.tree.total_mass[0], 0.02 * coarse.tree.total_mass[0]);
}

TEST(Discretisation, ANarrowProfileAsksForFinerCellsInTheSameLight) {
  Material wide = test::library_material("wholemilk"), narrow = wide;
  for (int c = 0; c < 3; ++c) narrow.sigma_a[c] = 20, narrow.sigma_s_prime[c] = 50, wide.sigma_s_prime[c] = 0.2;
  Cut a(subjects()[0], "wholemilk"), b(subjects()[0], "wholemilk");
  a.scene.materials[0] = wide, b.scene.materials[0] = narrow;
  const double r_max = 1.01 * diameter(a.scene.objects[0].mesh);
  a.profiles = ChannelProfiles(*find_profile("standard_dipole"), wide, r_max);
  b.profiles = ChannelProfiles(*find_profile("standard_dipole"), narrow, r_max);
  EXPECT_LT(a.discretise(500, 5e-3).cells.size(), b.discretise(500, 5e-3).cells.size());
}

TEST(Discretisation, EvenLightNeedsNothing) {
  Cut cut({"plate", plate, {DirectionalLight{glm::dvec3(0, 0, -1), Rgb(1), 0}}}, "skin1");
  const Discretisation d = cut.discretise(100, 1e-5);
  EXPECT_EQ(d.rounds, 0);
  EXPECT_EQ(d.error, 0);
  EXPECT_EQ(cut.counters.skipped["discretisation_estimates"], 1u);
  EXPECT_EQ(cut.counters.done.count("discretisation_points"), 0u);
}

TEST(Discretisation, TheLimitOfCellsHoldsAndIsCounted) {
  Cut cut(subjects()[2], "skin1");
  const Discretisation d = cut.discretise(300, 1e-5, 4000);
  EXPECT_LE(d.cells.size(), 6000u);
  EXPECT_GT(d.error, 1e-5) << "it says that it fell short";
  EXPECT_GT(cut.counters.skipped["cells_beyond_limit"], 0u);
}

TEST(Discretisation, InTheDarkThereIsNothingToDo) {
  Cut cut({"plate", plate, {DirectionalLight{glm::dvec3(0, 0, -1), Rgb(0), 0}}}, "skin1");
  const Discretisation d = cut.discretise(100, 1e-3);
  EXPECT_EQ(d.error, 0);
  EXPECT_TRUE(d.tree.nodes.empty());
}

}  // namespace
}  // namespace opaline
