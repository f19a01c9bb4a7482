// The hierarchical gather against the sum over all cells; what the sum itself is worth is in
// gather_oracle_test.cpp.
#include "render/irradiance/gather.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

#include <tbb/global_control.h>

#include <map>
#include <numeric>

namespace opaline {
namespace {

using test::brute_force;
using test::by_error;
using test::by_solid_angle;
using test::GatherFixture;
using test::library_material;
using test::relative_difference;

struct Subject {
  Mesh mesh;
  double height;
};

/// The objects of the accuracy test, each made once.
const Subject& subject(const std::string& name) {
  static std::map<std::string, Subject> made;
  if (!made.count(name)) {
    if (name == "sphere") made[name] = {make_sphere(10, 2000), 22};
    if (name == "torus") made[name] = {make_torus(8, 3, 2000), 24};
    if (name == "bust") made[name] = {make_bust(40, 4000), 44};
    if (name == "slab") made[name] = {make_slab({20, 20, 1}, 2000), 24};
  }
  return made.at(name);
}

/// A shape of a material under a light, with its visible points.
struct Picture {
  Scene scene;
  RayScene rays;
  std::vector<glm::vec3> points;
  GatherFixture gather;

  Picture(Scene s, std::size_t cells)
      : scene(std::move(s)), rays(scene), points(visible(scene, rays)), gather(make(scene, rays, cells)) {}

  static std::vector<glm::vec3> visible(const Scene& scene, const RayScene& rays) {
    std::vector<glm::vec3> points;
    for (const VisiblePoint& p : make_gbuffer(scene, rays).points) points.push_back(p.position);
    return points;
  }
  static GatherFixture make(const Scene& scene, const RayScene& rays, std::size_t count) {
    const SurfaceCells cells = make_surface_cells(scene.objects[0].mesh, count);
    Counters ignored;
    auto fields = compute_irradiance(scene, rays, {cells}, {{scene.materials[0].eta}}, {}, ignored);
    return {cells, std::move(fields[0]), scene.materials[0], 1.01 * diameter(scene.objects[0].mesh)};
  }
  float floor() const { return 1e-3f * test::mean_lit_irradiance(gather.cells, gather.field); }
};

Picture picture(const std::string& shape, const std::string& material, int pixels = 12, std::size_t cells = 8000) {
  return {test::make_scene(subject(shape).mesh, library_material(material), subject(shape).height, pixels), cells};
}

class GatherAccuracy : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

// The setting is a promise about the RMS over a picture. Measured: at most 0.25 of it at 1e-2 and 1e-3, 0.34 at 1e-4,
// and the worst point within it; the reference itself is good to 1.5e-6.
TEST_P(GatherAccuracy, StaysWithinTheTolerance) {
  const auto& [shape, material] = GetParam();
  const Picture p = picture(shape, material);
  const std::vector<glm::vec3> exact = p.gather.gather(p.points, brute_force());
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    const std::vector<glm::vec3> got = p.gather.gather(p.points, by_error(tolerance));
    for (int c = 0; c < 3; ++c) {
      const auto difference = relative_difference(got, exact, c, p.floor());
      EXPECT_GT(difference.count, 30u) << "too few pixels to mean anything";
      EXPECT_LT(difference.rms, tolerance) << "channel " << c;
      EXPECT_LT(difference.worst, 5 * tolerance) << "channel " << c;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(ShapesAndMaterials, GatherAccuracy,
                         testing::Combine(testing::Values("sphere", "torus", "bust", "slab"),
                                          testing::Values("wholemilk", "skin1", "marble", "ketchup")),
                         [](const auto& row) { return std::get<0>(row.param) + "_" + std::get<1>(row.param); });

TEST(Gather, ColouredLightsAreAsExactAsWhite) {
  Scene scene = test::make_scene(make_sphere(10, 2000), library_material("skin1"), 22, 12);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(1, 0, -0.4)), Rgb(1, 0.2, 0), 0},
                  DirectionalLight{glm::normalize(glm::dvec3(-1, 0.3, -0.4)), Rgb(0, 0.3, 2), 0}};
  const Picture p(scene, 8000);
  ASSERT_EQ(p.gather.field.channels, 3);
  const std::vector<glm::vec3> exact = p.gather.gather(p.points, brute_force());
  for (const double tolerance : {1e-2, 1e-3, 1e-4}) {
    const std::vector<glm::vec3> got = p.gather.gather(p.points, by_error(tolerance));
    for (int c = 0; c < 3; ++c) EXPECT_LT(relative_difference(got, exact, c, p.floor()).rms, tolerance) << c;
  }
}

TEST(Gather, FewerClustersForLessExactPictures) {
  const Picture p = picture("sphere", "wholemilk", 24);
  const auto work = [&](double tolerance) {
    Counters counters;
    p.gather.gather(p.points, by_error(tolerance), &counters);
    EXPECT_EQ(counters.done["queries"], p.points.size());
    EXPECT_EQ(counters.skipped["cell_splits_at_depth_limit"], 0u);
    return counters.done["clusters"] + counters.done["cells"] + counters.done["cell_parts"];
  };
  EXPECT_LT(work(1e-2), work(1e-3));
  EXPECT_LT(work(1e-3), work(1e-4));
  EXPECT_LT(work(1e-3), p.points.size() * p.gather.cells.size() / 2);
}

// --- what must not depend on how the work is shared out --------------------------------------------

TEST(Gather, TheSamePictureForAnyNumberOfThreads) {
  const Picture p = picture("torus", "skin1", 32);
  for (const GatherSettings& settings : {brute_force(1e-3), by_error(1e-3), by_solid_angle(0.2)}) {
    std::vector<glm::vec3> one, two;
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
      one = p.gather.gather(p.points, settings);
    }
    {
      const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 2);
      two = p.gather.gather(p.points, settings);
    }
    EXPECT_EQ(one, two);
  }
}

TEST(Gather, APointAloneAgreesWithThePointInItsGroup) {
  const Picture p = picture("sphere", "wholemilk");
  const std::vector<glm::vec3> exact = p.gather.gather(p.points, brute_force());
  for (std::size_t i = 0; i < p.points.size(); i += 7) {
    const glm::vec3 alone = p.gather.gather(std::span(p.points).subspan(i, 1), brute_force())[0];
    const glm::vec3 estimated = p.gather.gather(std::span(p.points).subspan(i, 1), by_error(1e-3))[0];
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(alone[c], exact[i][c], 1e-5f * exact[i][c]);
      EXPECT_NEAR(estimated[c], exact[i][c], 5e-3f * std::max(exact[i][c], p.floor()));
    }
  }
}

TEST(Gather, NoPointsNoWork) {
  const Picture p = picture("sphere", "wholemilk");
  EXPECT_TRUE(p.gather.gather({}, by_error(1e-3)).empty());
}

TEST(MortonOrder, IsAPermutationThatKeepsNeighboursTogether) {
  std::vector<glm::vec3> grid;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) grid.emplace_back(x, y, 3);
  std::vector<std::uint32_t> order;
  for (const MortonKey& key : morton_sorted(grid)) order.push_back(key.index);
  std::vector<std::uint32_t> sorted = order, all(grid.size());
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0u);
  EXPECT_EQ(sorted, all);
  double path = 0;
  for (std::size_t i = 1; i < order.size(); ++i) path += glm::length(grid[order[i]] - grid[order[i - 1]]);
  // A Z curve on a grid takes steps of 1.6 cells in the mean; a random order takes 8.
  EXPECT_LT(path / 255, 2.0);
}

// --- work that is not done -------------------------------------------------------------------------

TEST(Gather, EqualChannelsAreComputedOnce) {
  Material grey = library_material("marble"), nearly = grey;
  grey.sigma_a = Rgb(0.01), grey.sigma_s_prime = Rgb(2);
  nearly.sigma_a = {0.01, 0.01 * (1 + 1e-12), 0.01 * (1 - 1e-12)}, nearly.sigma_s_prime = Rgb(2);
  const Mesh mesh = make_sphere(10, 2000);
  const Picture once(test::make_scene(mesh, grey, 22, 12), 8000), thrice(test::make_scene(mesh, nearly, 22, 12), 8000);
  Counters counters, separate;
  const auto a = once.gather.gather(once.points, by_error(1e-3), &counters);
  const auto b = thrice.gather.gather(thrice.points, by_error(1e-3), &separate);
  EXPECT_EQ(counters.done["channels"], 1u);
  EXPECT_EQ(counters.skipped["equal_channels"], 2u);
  EXPECT_EQ(separate.done["channels"], 3u);
  EXPECT_EQ(separate.skipped["equal_channels"], 0u);
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_EQ(a[i][c], a[i][0]);
      EXPECT_NEAR(a[i][c], b[i][c], 1e-6f * b[i][c]);
    }
}

TEST(Gather, TwoEqualChannelsOfThreeShareATable) {
  Material material = library_material("marble");
  material.sigma_a = {0.01, 0.02, 0.01}, material.sigma_s_prime = {2, 2, 2};
  const ChannelProfiles profiles(*find_profile("standard_dipole"), material, 20);
  EXPECT_EQ(profiles.distinct(), 2);
  EXPECT_EQ(profiles.sum().table_of[0], profiles.sum().table_of[2]);
  EXPECT_NE(profiles.sum().table_of[0], profiles.sum().table_of[1]);
}

TEST(Gather, InTheDarkEverythingIsExactlyBlack) {
  Scene scene = test::make_scene(make_sphere(10, 500), library_material("wholemilk"), 22, 12);
  scene.lights = {DirectionalLight{glm::dvec3(0, 0, -1), Rgb(0), 0}};
  const Picture p(scene, 1000);
  EXPECT_TRUE(p.gather.tree.nodes.empty());
  for (const GatherSettings& settings : {brute_force(), by_error(1e-3), by_solid_angle(0.2)}) {
    Counters counters;
    for (const glm::vec3& b : p.gather.gather(p.points, settings, &counters)) EXPECT_EQ(b, glm::vec3(0));
    EXPECT_EQ(counters.done["queries"], p.points.size());
    EXPECT_EQ(counters.skipped["dark_cells"], p.gather.cells.size());
    EXPECT_EQ(counters.done["clusters"] + counters.done["cells"], 0u);
  }
}

// --- the published criterion -----------------------------------------------------------------------

// R_d is convex in the squared distance, so a point in place of a cluster always gives too little.
TEST(Gather, TheSolidAngleCriterionIsTooDarkAndLessSoWithQuality) {
  for (const char* material : {"wholemilk", "skin1", "marble"}) {
    const Picture p = picture("sphere", material, 24, 20000);
    const std::vector<glm::vec3> exact = p.gather.gather(p.points, brute_force(1e-4));
    for (int c = 0; c < 3; ++c) {
      double before = -1;
      // Measured, red milk: -11 %, -2 %, -0.6 %. Below that the random placement of the cells shows.
      for (const double quality : {1.0, 0.2, 0.05}) {
        const double mean =
            relative_difference(p.gather.gather(p.points, by_solid_angle(quality)), exact, c, p.floor()).mean;
        EXPECT_LT(mean, 0) << material << " " << quality << " channel " << c;
        EXPECT_GT(mean, before / 1.5) << material << " " << quality << " channel " << c;
        before = mean;
      }
    }
  }
}

TEST(Gather, TheSolidAngleCriterionSumsPointsAndNothingElse) {
  // Written out: the cut of the tree where nodes look small from outside, each a point at its centroid.
  const Picture p = picture("sphere", "marble", 6, 500);
  const ClusterTree& tree = p.gather.tree;
  const std::vector<glm::vec3> got = p.gather.gather(p.points, by_solid_angle(0.3));
  for (std::size_t i = 0; i < p.points.size(); ++i) {
    double sum = 0;
    for (std::size_t n = 0; n < tree.nodes.size();) {
      const ClusterNode& node = tree.nodes[n];
      const double d = static_cast<double>(glm::length(node.centroid - p.points[i]));
      const bool inner = node.cell == ClusterNode::no_cell;
      const bool small = d > static_cast<double>(node.extent.radius) && static_cast<double>(node.area) < 0.3 * d * d;
      if (!inner || small) sum += static_cast<double>(tree.mass[n]) * p.gather.profiles.profile(1).evaluate(d);
      n = !inner || small ? node.skip : n + 1;
    }
    EXPECT_NEAR(got[i].y, sum, 1e-4 * sum);
  }
}

}  // namespace
}  // namespace opaline
