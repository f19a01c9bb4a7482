#include "render/irradiance/cluster_tree.h"

#include "datasets_synthetic/shapes/shapes.h"
#include "tests/support/render_fixture.h"

#include <tbb/global_control.h>

#include <cstring>
#include <set>

namespace opaline {
namespace {

/// Irradiance that differs from cell to cell and channel to channel; every third cell is dark.
IrradianceField varied(std::size_t cells, int etas, int channels) {
  IrradianceField field{etas, channels, Rgb(1), {}};
  for (std::size_t i = 0; i < cells; ++i)
    for (int m = 0; m < etas * channels; ++m) {
      const float wave = std::sin(0.37f * static_cast<float>(i) + static_cast<float>(m));
      field.values.push_back(i % 3 == 0 ? 0.0f : 1.1f + wave);
    }
  return field;
}

/// Flux, centroid and second moments of a set of cells and one weight per cell, summed directly in double.
struct Moments {
  double mass = 0;
  glm::dvec3 first{0};
  glm::dmat3 second{0};

  void add(const SurfaceCell& cell, double weight) {
    const glm::dvec3 v[3] = {glm::dvec3(cell.a), glm::dvec3(cell.b), glm::dvec3(cell.c)};
    const double flux = weight * static_cast<double>(cell_area(cell));
    // The mid-edge rule is exact for quadratics.
    for (int k = 0; k < 3; ++k) {
      const glm::dvec3 p = (v[k] + v[(k + 1) % 3]) / 2.0;
      mass += flux / 3;
      first += flux / 3 * p;
      second += flux / 3 * glm::outerProduct(p, p);
    }
  }
  glm::dvec3 centroid() const { return first / mass; }
  glm::dmat3 covariance() const { return second / mass - glm::outerProduct(centroid(), centroid()); }
};

/// The cells below a node.
std::vector<std::uint32_t> leaves(const ClusterTree& tree, std::size_t node) {
  std::vector<std::uint32_t> cells;
  for (std::size_t i = node; i < tree.nodes[node].skip; ++i)
    if (tree.nodes[i].cell != ClusterNode::no_cell) cells.push_back(tree.nodes[i].cell);
  return cells;
}

float weight_of(const IrradianceField& field, std::size_t cell) {
  float sum = 0;
  const auto width = static_cast<std::size_t>(field.width());
  for (std::size_t m = 0; m < width; ++m) sum += field.values[cell * width + m];
  return sum;
}

struct Built {
  SurfaceCells cells = make_surface_cells(make_sphere(10, 320), 1000);
  IrradianceField field;
  ClusterTree tree;
  explicit Built(int channels = 1, int etas = 1)
      : field(varied(cells.size(), etas, channels)), tree(build_cluster_tree(cells, field)) {}
};

TEST(ClusterTree, NodesCarryTheMomentsOfTheirCells) {
  const Built b;
  for (std::size_t n = 0; n < b.tree.nodes.size(); n += n < 20 ? 1 : 37) {
    const ClusterNode& node = b.tree.nodes[n];
    Moments direct;
    double area = 0;
    for (const std::uint32_t cell : leaves(b.tree, n)) {
      direct.add(b.cells[cell], static_cast<double>(b.field.values[cell]));
      area += static_cast<double>(cell_area(b.cells[cell]));
    }
    EXPECT_NEAR(b.tree.mass[n], direct.mass, 1e-5 * direct.mass);
    EXPECT_NEAR(node.area, area, 1e-5 * area);
    EXPECT_LT(glm::length(glm::dvec3(node.centroid) - direct.centroid()), 1e-5);
    const glm::dmat3 c = direct.covariance();
    const double expected[6] = {c[0][0], c[1][0], c[2][0], c[1][1], c[2][1], c[2][2]};
    const double trace = c[0][0] + c[1][1] + c[2][2];
    for (int k = 0; k < 6; ++k) EXPECT_NEAR(node.covariance[k], expected[k], 1e-5 * trace + 1e-9) << n << " " << k;
    EXPECT_NEAR(node.extent.trace, trace, 1e-5 * trace + 1e-9);
  }
}

TEST(ClusterTree, EveryNodeContainsItsCells) {
  const Built b;
  for (std::size_t n = 0; n < b.tree.nodes.size(); ++n) {
    const ClusterNode& node = b.tree.nodes[n];
    float farthest = 0;
    for (const std::uint32_t cell : leaves(b.tree, n))
      for (const glm::vec3& p : {b.cells[cell].a, b.cells[cell].b, b.cells[cell].c})
        farthest = std::max(farthest, glm::length(p - node.centroid));
    EXPECT_LE(farthest, node.extent.radius * 1.00001f) << n;
    // Large nodes know only the boxes and spheres of their children.
    EXPECT_GE(farthest, node.extent.radius * (leaves(b.tree, n).size() <= 32 ? 0.99999f : 0.55f)) << n;
  }
}

TEST(ClusterTree, TheSkipPointersPartitionTheLitCells) {
  const Built b;
  const ClusterTree& tree = b.tree;
  EXPECT_EQ(tree.nodes[0].skip, tree.nodes.size());
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    if (tree.nodes[n].cell != ClusterNode::no_cell) {
      EXPECT_EQ(tree.nodes[n].skip, n + 1);
      continue;
    }
    const std::size_t left = n + 1, right = tree.nodes[left].skip;
    ASSERT_LT(right, tree.nodes[n].skip);
    EXPECT_EQ(tree.nodes[right].skip, tree.nodes[n].skip);
  }
  const std::vector<std::uint32_t> all = leaves(tree, 0);
  const std::set<std::uint32_t> unique(all.begin(), all.end());
  EXPECT_EQ(unique.size(), all.size()) << "a cell twice";
  std::set<std::uint32_t> lit;
  for (std::size_t i = 0; i < b.cells.size(); ++i)
    if (b.field.values[i] > 0) lit.insert(static_cast<std::uint32_t>(i));
  EXPECT_EQ(unique, lit);
  EXPECT_EQ(tree.dark_cells, b.cells.size() - lit.size());
  EXPECT_GT(tree.dark_cells, 300u);
}

TEST(ClusterTree, EachChannelHasItsFluxAndFirstMoment) {
  const Built b(3, 2);
  ASSERT_EQ(b.tree.masses, 6);
  for (const std::size_t n : {0, 1, 2, 5, 40, 333, 1000}) {
    const ClusterNode& node = b.tree.nodes[n];
    Moments all;
    for (std::size_t m = 0; m < 6; ++m) {
      Moments one;
      for (const std::uint32_t cell : leaves(b.tree, n))
        one.add(b.cells[cell], static_cast<double>(b.field.values[cell * 6 + m]));
      EXPECT_NEAR(b.tree.mass[n * 6 + m], one.mass, 1e-5 * one.mass);
      const glm::dvec3 about = one.first - one.mass * glm::dvec3(node.centroid);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(b.tree.first_moment[(n * 3 + axis) * 6 + m], about[static_cast<int>(axis)], 1e-5 * one.mass);
    }
    for (const std::uint32_t cell : leaves(b.tree, n))
      all.add(b.cells[cell], static_cast<double>(weight_of(b.field, cell)));
    EXPECT_LT(glm::length(glm::dvec3(node.centroid) - all.centroid()), 1e-5);
  }
}

TEST(ClusterTree, CountsTheFluxOfEveryChannel) {
  const Built b(3);
  for (std::size_t m = 0; m < 3; ++m) {
    double flux = 0;
    for (std::size_t i = 0; i < b.cells.size(); ++i)
      flux += static_cast<double>(b.field.values[i * 3 + m]) * static_cast<double>(cell_area(b.cells[i]));
    EXPECT_NEAR(b.tree.total_mass[m], flux, 1e-12 * flux);
  }
}

TEST(ClusterTree, OneThreadOrTwoBuildTheSameTree) {
  const SurfaceCells cells = make_surface_cells(make_sphere(10, 320), 20000);  // large enough to be split
  const IrradianceField field = varied(cells.size(), 1, 3);
  const auto build = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return build_cluster_tree(cells, field);
  };
  const ClusterTree one = build(1), two = build(2);
  ASSERT_EQ(one.nodes.size(), two.nodes.size());
  EXPECT_EQ(std::memcmp(one.nodes.data(), two.nodes.data(), one.nodes.size() * sizeof(ClusterNode)), 0);
  EXPECT_EQ(one.mass, two.mass);
  EXPECT_EQ(one.first_moment, two.first_moment);
}

TEST(ClusterTree, CellsAtOnePlaceMakeATree) {
  // All centroids equal: no axis separates them, the index does.
  const SurfaceCells cells(100, SurfaceCell{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0});
  const ClusterTree tree = build_cluster_tree(cells, test::constant_irradiance(100, 2));
  EXPECT_EQ(tree.nodes.size(), 199u);
  EXPECT_NEAR(tree.mass[0], 100, 1e-4);
  EXPECT_NEAR(tree.nodes[0].extent.trace, 1.0 / 9, 1e-6);  // of one triangle: (1 + 1 + 2) / 36
}

TEST(ClusterTree, NothingLitNoNodes) {
  const SurfaceCells cells = make_surface_cells(make_sphere(10, 80), 80);
  const ClusterTree tree = build_cluster_tree(cells, test::constant_irradiance(80, 0));
  EXPECT_TRUE(tree.nodes.empty());
  EXPECT_EQ(tree.dark_cells, 80u);
  EXPECT_EQ(tree.total_mass, std::vector<double>{0.0});
}

}  // namespace
}  // namespace opaline
