#include "render/irradiance/all_pairs.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "render/irradiance/profile_gather.h"
#include "tests/support/render_fixture.h"

#include <cmath>
#include <limits>

namespace opaline {
namespace {

/// Asks for parts where the two-point rule's third-order remainder may exceed a tolerance.
struct Remainder {
  const ChannelProfiles& profiles;
  float tolerance;

  void begin_group(const glm::vec3&, float) {}
  /// -d ln R/dr, at least that of a power beyond the core: largest a little outside it.
  float steepness(double r) const {
    const Profile& p = profiles.profile(0);
    const double h = 1e-3 * (r + p.core_radius());
    return static_cast<float>(std::log(p.evaluate(r) / p.evaluate(r + h)) / h + 1 / std::hypot(r, p.core_radius()));
  }
  bool accept(const ClusterExtent& e, float distance, float) const {
    const auto core = static_cast<float>(profiles.profile(0).core_radius());
    const float s = steepness(static_cast<double>(distance));
    const float radius2 = e.radius * e.radius;
    return radius2 < 0.5f * (distance * distance + core * core) && 0.003f * s * s * s * e.radius * radius2 < tolerance;
  }
};

struct Result {
  std::vector<std::array<float, 3>> sums;
  GatherCounts counts;
};

Result all_pairs(const SurfaceCells& cells, int fluxes, const char* material, float falling_from) {
  IrradianceField irradiance{1, fluxes, Rgb(1), std::vector<float>(cells.size() * static_cast<std::size_t>(fluxes), 1)};
  for (std::size_t i = 0; i < irradiance.values.size(); i += 5) irradiance.values[i] = 0.5f;
  const ClusterTree tree = build_cluster_tree(cells, irradiance);
  const ChannelProfiles profiles(*find_profile("standard_dipole"), test::library_material(material), 5);
  std::vector<glm::vec3> points;
  for (std::size_t i = 0; i < cells.size(); i += 7) points.push_back(cells[i].a);
  Result result;
  result.sums.resize(points.size());
  const Remainder criterion{profiles, 1e-4f};
  const float from = falling_from * static_cast<float>(profiles.profile(0).core_radius());
  result.counts = sum_all_pairs(tree, cells, profiles.sum(), points, criterion, from, result.sums);
  return result;
}

TEST(AllPairs, FindsTheNearCellsWithoutLookingAtAll) {
  const SurfaceCells cells = make_surface_cells(make_sphere(2, 800), 2000);
  for (const char* material : {"skin1", "wholemilk", "ketchup"})
    for (const int fluxes : {1, 3}) {
      const Result all = all_pairs(cells, fluxes, material, std::numeric_limits<float>::infinity()),
                   culled = all_pairs(cells, fluxes, material, 4);
      EXPECT_EQ(culled.sums, all.sums) << material;
      EXPECT_EQ(culled.counts.cells, all.counts.cells) << material;
      EXPECT_EQ(culled.counts.cell_parts, all.counts.cell_parts) << material;
      EXPECT_LE(culled.counts.nodes_visited, all.counts.nodes_visited) << material;
    }
  EXPECT_LT(2 * all_pairs(cells, 1, "wholemilk", 4).counts.nodes_visited,
            all_pairs(cells, 1, "wholemilk", std::numeric_limits<float>::infinity()).counts.nodes_visited);
}

TEST(AllPairs, EveryCellIsSummedWholeOrInParts) {
  const SurfaceCells cells = make_surface_cells(make_sphere(2, 800), 2000);
  const Result r = all_pairs(cells, 1, "wholemilk", 4);
  const std::size_t pairs = r.sums.size() * cells.size();
  ASSERT_LT(r.counts.cells, pairs);
  EXPECT_GE(r.counts.cell_parts, 4 * (pairs - r.counts.cells));
}

}  // namespace
}  // namespace opaline
