#include "render/irradiance/profile_sum.h"

#include "model/profile_batch.h"
#include "model/simd.h"
#include "tests/support/exitance_oracle.h"
#include "tests/support/render_fixture.h"
#include "tests/support/two_point_rule.h"

#include <random>

namespace opaline {
namespace {

/// A tree whose nodes are anything: random places, sizes, fluxes. Only what PatchList::push reads is set.
ClusterTree random_patches(std::size_t count, int masses) {
  std::mt19937 random(count * 7 + static_cast<std::size_t>(masses));
  std::uniform_real_distribution<float> any(-1, 1), positive(0.1f, 1);
  ClusterTree tree;
  tree.masses = masses;
  for (std::size_t i = 0; i < count; ++i) {
    ClusterNode node{};
    node.centroid = {3 * any(random), 3 * any(random), 3 * any(random)};
    test::give_moments(node, 0.4f, [&] { return any(random); });
    tree.nodes.push_back(node);
    for (int m = 0; m < masses; ++m) tree.mass.push_back(positive(random));
    for (int m = 0; masses > 1 && m < 3 * masses; ++m) tree.first_moment.push_back(0.05f * any(random));
  }
  return tree;
}

PatchList patches_of(const ClusterTree& tree) {
  PatchList list(tree.masses);
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) list.push(tree, i);
  list.pad();
  return list;
}

/// R of one of the tables, by the form of table that the vector target in force uses (tested in tests/model).
double table_value(const ProfileSum& profile, int table, double q) {
  float values[3], r2 = static_cast<float>(q);
  float* out[] = {&values[0], &values[1], &values[2]};
  evaluate_tables(profile.tables, profile.table_count, &r2, 1, out);
  return static_cast<double>(values[table]);
}

/// What add_profile_sum must add, one double loop. sums[t] for one flux channel, sums[c] for three.
std::array<double, 3> reference_sum(const ProfileSum& profile, const ClusterTree& tree, const float* weight,
                                    const glm::vec3& position) {
  std::array<double, 3> sums{};
  for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
    const test::TwoPointRule rule = test::two_point_rule(tree.nodes[i], position);
    const double w = weight ? static_cast<double>(weight[i]) : 1.0;
    const auto at = [&](int table, double q) { return table_value(profile, table, q); };
    for (int t = 0; tree.masses == 1 && t < profile.table_count; ++t)
      sums[static_cast<std::size_t>(t)] +=
          w * static_cast<double>(tree.mass[i]) *
          (rule.share_of_near * at(t, rule.near) + (1 - rule.share_of_near) * at(t, rule.far));
    for (std::size_t c = 0; tree.masses == 3 && c < 3; ++c) {
      const glm::dvec3 moment(tree.first_moment[(3 * i + 0) * 3 + c], tree.first_moment[(3 * i + 1) * 3 + c],
                              tree.first_moment[(3 * i + 2) * 3 + c]);
      const double near = at(profile.table_of[c], rule.near), far = at(profile.table_of[c], rule.far);
      sums[c] += w * (static_cast<double>(tree.mass[i * 3 + c]) *
                          (rule.share_of_near * near + (1 - rule.share_of_near) * far) +
                      glm::dot(rule.d, moment) / rule.spread * (near - far));
    }
  }
  return sums;
}

ProfileTable power_table(double core, double exponent) {
  return ProfileTable([=](double r) { return std::pow(r * r + core * core, -exponent / 2); }, core, 20);
}

struct NoLimitAfterwards {
  ~NoLimitAfterwards() { limit_simd_target(""); }
};

void expect_every_target_agrees(const ProfileSum& profile, std::size_t count, int masses, bool weighted) {
  const ClusterTree tree = random_patches(count, masses);
  const PatchList patches = patches_of(tree);
  std::vector<float> weight(PatchList::padded(count), 1.0f);
  for (std::size_t i = 0; i < count; i += 3) weight[i] = i % 2 ? 0.25f : 0.0f;
  const float* w = weighted ? weight.data() : nullptr;
  const glm::vec3 position(0.4f, -0.7f, 0.2f);
  const int sums = masses == 1 ? profile.table_count : 3;
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    const std::array<double, 3> expected = reference_sum(profile, tree, w, position);
    float got[3] = {1, 2, 3};  // the function adds to what is there
    add_profile_sum(profile, patches, w, position, got);
    for (int k = 0; k < 3; ++k) {
      const double want = k + 1 + (k < sums ? expected[static_cast<std::size_t>(k)] : 0);
      // A table lookup is a cubic in float, near a tenth of its value off by 1e-6 where q itself is rounded.
      EXPECT_NEAR(got[k], want, 2e-6 * want) << target << " patches " << count << " fluxes " << masses << " sum " << k;
    }
  }
}

TEST(ProfileSum, EveryInstructionSetAgreesWithTheWrittenOutRule) {
  const NoLimitAfterwards guard;
  const ProfileTable a = power_table(0.5, 3), b = power_table(1, 5), c = power_table(2, 2);
  for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 100u})
    for (const bool weighted : {false, true}) {
      for (int tables = 1; tables <= 3; ++tables)
        expect_every_target_agrees({{&a, &b, &c}, tables, {}}, count, 1, weighted);
      expect_every_target_agrees({{&a, &b, &c}, 3, {0, 1, 2}}, count, 3, weighted);
      expect_every_target_agrees({{&a, &b}, 2, {1, 0, 1}}, count, 3, weighted);
      expect_every_target_agrees({{&a}, 1, {0, 0, 0}}, count, 3, weighted);
    }
}

/// Whatever a patch's moments: it gives no more than its flux at its nearest point would, and no less than at its
/// farthest. Of a profile that falls fast a value from nearer than the patch is anything.
TEST(ProfileSum, APatchGivesWhatItsPlaceAllows) {
  const NoLimitAfterwards guard;
  const ProfileTable steep([](double r) { return std::exp(-12 * r) / (r + 1e-3); }, 1e-3, 20);
  const ProfileSum profile{{&steep}, 1, {0, 0, 0}};
  const ClusterTree tree = random_patches(4000, 1);
  std::mt19937 random(11);
  std::normal_distribution<float> any;
  std::uniform_real_distribution<float> away(1.02f, 2);
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      PatchList one(1);
      one.push(tree, i);
      one.pad();
      const ClusterNode& node = tree.nodes[i];
      const glm::vec3 to = glm::normalize(glm::vec3(any(random), any(random), any(random)));
      const glm::vec3 position = node.centroid + away(random) * node.extent.radius * to;
      float sum[3] = {};
      add_profile_sum(profile, one, nullptr, position, sum);
      const double d = glm::length(glm::dvec3(position) - glm::dvec3(node.centroid)), r = node.extent.radius;
      const auto at = [&](double distance) { return table_value(profile, 0, distance * distance); };
      ASSERT_LE(sum[0], 1.001 * tree.mass[i] * at(d - r)) << target << " patch " << i;
      ASSERT_GE(sum[0], 0.999 * tree.mass[i] * at(d + r)) << target << " patch " << i;
    }
  }
}

TEST(ProfileSum, TablesOfOneSegmentationAgreeToo) {
  const NoLimitAfterwards guard;
  const auto table = [](double core, double exponent, double r_max) {
    return ProfileTable([=](double r) { return std::pow(r * r + core * core, -exponent / 2); }, 0.5, r_max);
  };
  for (const double r_max : {20.0, 1000.0, 1e5}) {  // the two register forms and rows
    const ProfileTable a = table(0.5, 3, r_max), b = table(1, 5, r_max), c = table(2, 2, r_max);
    for (const std::size_t count : {16u, 100u, 511u, 512u, 513u, 1100u})
      for (const int masses : {1, 3}) {
        for (int tables = 1; masses == 1 && tables <= 3; ++tables)
          expect_every_target_agrees({{&a, &b, &c}, tables, {}}, count, 1, true);
        if (masses == 3) expect_every_target_agrees({{&a, &b, &c}, 3, {2, 0, 1}}, count, 3, false);
      }
  }
}

TEST(ProfileSum, ManyQueriesAreTheQueriesOneByOne) {
  const ProfileTable table = power_table(0.5, 3);
  const ProfileSum profile{{&table}, 1, {0, 0, 0}};
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-3, 3);
  for (const int masses : {1, 3})
    for (const std::size_t queries : {0u, 1u, 2u, 64u, 65u, 130u}) {
      const PatchList patches = patches_of(random_patches(1300, masses));
      std::vector<glm::vec3> positions(queries);
      for (glm::vec3& p : positions) p = {any(random), any(random), any(random)};
      std::vector<std::array<float, 3>> together(queries), alone(queries);
      add_profile_sums(profile, patches, nullptr, positions, together.data());
      for (std::size_t q = 0; q < queries; ++q)
        add_profile_sum(profile, patches, nullptr, positions[q], alone[q].data());
      EXPECT_EQ(together, alone) << queries << " queries, fluxes " << masses;
    }
}

TEST(ProfileSum, SkippedPatchesAreThoseOfNoWeight) {
  const ProfileTable table = power_table(0.5, 3);
  const ProfileSum profile{{&table}, 1, {0, 0, 0}};
  for (const int masses : {1, 3}) {
    const PatchList patches = patches_of(random_patches(1300, masses));
    const std::vector<std::uint32_t> skipped[] = {{}, {0}, {511, 512, 513}, {5, 700, 1299}, {1298}};
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 5; ++i) positions.push_back({0.3f * static_cast<float>(i), 0.2f, -0.1f});
    std::vector<std::array<float, 3>> sums(5);
    add_profile_sums(profile, patches, positions, skipped, sums.data());
    for (std::size_t q = 0; q < 5; ++q) {
      std::vector<float> weight(PatchList::padded(1300), 1.0f);
      for (const std::uint32_t i : skipped[q]) weight[i] = 0;
      std::array<float, 3> expected{};
      add_profile_sum(profile, patches, weight.data(), positions[q], expected.data());
      EXPECT_EQ(sums[q], expected) << "query " << q << " fluxes " << masses;
    }
  }
}

TEST(ProfileSum, AMillionEqualPatchesDoNotDrift) {
  ClusterTree tree;
  ClusterNode node{};
  node.centroid = {1, 0, 0};
  tree.nodes = {node};
  tree.mass = {1};
  PatchList list;
  for (int i = 0; i < 1000000; ++i) list.push(tree, 0);
  list.pad();
  const ProfileTable table = power_table(0.5, 3);
  float sum[3] = {0, 0, 0}, one[3] = {0, 0, 0};
  add_profile_sum({{&table}, 1, {}}, list, nullptr, glm::vec3(0), sum);
  list.clear();
  list.push(tree, 0);
  list.pad();
  add_profile_sum({{&table}, 1, {}}, list, nullptr, glm::vec3(0), one);
  EXPECT_NEAR(sum[0], 1e6f * one[0], 2e-6f * sum[0]);
}

TEST(ProfileSum, PatchesBeyondTheEndOfAListAreNotSummed) {
  // Shrinking a list leaves old patches behind its end; pad() must wipe them.
  const ClusterTree tree = random_patches(40, 3);
  PatchList list(3);
  for (std::size_t i = 0; i < 40; ++i) list.push(tree, i);
  list.clear();
  list.push(tree, 5);
  list.pad();
  const ProfileTable table = power_table(0.5, 3);
  const ProfileSum profile{{&table}, 1, {0, 0, 0}};
  float got[3] = {0, 0, 0}, alone[3] = {0, 0, 0};
  add_profile_sum(profile, list, nullptr, glm::vec3(0), got);
  PatchList fresh(3);
  fresh.push(tree, 5);
  fresh.pad();
  add_profile_sum(profile, fresh, nullptr, glm::vec3(0), alone);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(got[c], alone[c]);
}

// --- the rule itself --------------------------------------------------------------------------------

/// A uniform disk of unit flux and that radius in the xy plane.
ClusterTree disk(float radius) {
  ClusterTree tree;
  ClusterNode node{};
  node.covariance[0] = node.covariance[3] = radius * radius / 4;
  node.extent.radius = radius;
  node.extent.trace = radius * radius / 2;
  node.extent.deviation = node.extent.trace / std::sqrt(3.0f);
  tree.nodes = {node};
  tree.mass = {1};
  return tree;
}

double sum_at(const ClusterTree& tree, const ProfileTable& table, const glm::vec3& position) {
  PatchList list;
  list.push(tree, 0);
  list.pad();
  float sum[3] = {0, 0, 0};
  add_profile_sum({{&table}, 1, {}}, list, nullptr, position, sum);
  return static_cast<double>(sum[0]);
}

TEST(TwoPointRule, IsGaussLegendreAtTheCentreOfADisk) {
  // Cubics in q are integrated exactly: the mean of q^n over a disk of radius a is a^2n / (n + 1).
  const ProfileTable table([](double r) { return 1 + r * r + std::pow(r, 4) + 2 * std::pow(r, 6); }, 1, 4);
  for (const double a : {0.5, 1.0, 1.5}) {
    const double q = a * a, exact = 1 + q / 2 + q * q / 3 + 2 * q * q * q / 4;
    EXPECT_NEAR(sum_at(disk(static_cast<float>(a)), table, glm::vec3(0)), exact, 2e-6 * exact) << a;
  }
}

TEST(TwoPointRule, HasTheMeanAndVarianceOfTheSquaredDistance) {
  const ProfileTable linear([](double r) { return r * r; }, 1, 6),
      square([](double r) { return std::pow(r, 4); }, 1, 6);
  const glm::vec3 position(0.9f, -0.5f, 0.7f);
  // Over the disk, by quadrature in its radius (in q: Gauss) and angle.
  double mean = 0, mean_square = 0;
  const double a = 1.2;
  const int n = 400;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const double r = a * std::sqrt((i + 0.5) / n), phi = 2 * pi * (j + 0.5) / n;
      const glm::dvec3 d = glm::dvec3(position) - glm::dvec3(r * std::cos(phi), r * std::sin(phi), 0);
      const double q = glm::dot(d, d);
      mean += q / (n * n), mean_square += q * q / (n * n);
    }
  EXPECT_NEAR(sum_at(disk(1.2f), linear, position), mean, 3e-6 * mean);
  EXPECT_NEAR(sum_at(disk(1.2f), square, position), mean_square, 3e-6 * mean_square);
}

/// Relative error of one patch for all the cells scaled by `size`, against fine subdivision.
double patch_error(SurfaceCells cells, float size, const glm::vec3& position) {
  for (SurfaceCell& cell : cells) cell = {size * cell.a, size * cell.b, size * cell.c, 0};
  const auto profile = [&](double r) { return std::pow(r * r + 0.25, -1.5); };
  double exact = 0;
  for (const SurfaceCell& cell : cells)
    exact +=
        test::integrate_triangle(glm::dvec3(cell.a), glm::dvec3(cell.b), glm::dvec3(cell.c), 1e-12,
                                 [&](const glm::dvec3& p) { return profile(glm::length(p - glm::dvec3(position))); });
  const ClusterTree tree = build_cluster_tree(cells, test::constant_irradiance(cells.size(), 1));
  return sum_at(tree, ProfileTable(profile, 0.05, 10), position) / exact - 1;
}

TEST(TwoPointRule, ConvergesWithTheThirdOrder) {
  // Halving a triangle about its centroid divides the error by 8; a patch without third moments by 16.
  const SurfaceCells triangle = {{{-1, -1, 0}, {2, -1, 0}, {-1, 2, 0}, 0}};
  const SurfaceCells square = {{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, 0}, {{-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, 0}};
  // Measured: 7.6 to 8.0, and 15.8. Positions beside the patch, in its plane and above it.
  for (const glm::vec3& position : {glm::vec3(0.6f, 0.9f, 0.3f), glm::vec3(0, -1.5f, 0), glm::vec3(1.5f, 0, 0)}) {
    EXPECT_GT(patch_error(triangle, 0.1f, position) / patch_error(triangle, 0.05f, position), 7.4);
    EXPECT_GT(patch_error(square, 0.2f, position) / patch_error(square, 0.1f, position), 15);
    EXPECT_LT(std::abs(patch_error(triangle, 0.05f, position)), 2e-4);
  }
}

}  // namespace
}  // namespace opaline
