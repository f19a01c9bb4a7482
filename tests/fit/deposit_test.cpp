// The radial basis, and the vectorised deposits into it against the rule written out in double.
#include "fit/deposit.h"
#include "model/materials/library.h"
#include "model/profiles/profile.h"
#include "model/simd.h"
#include "tests/support/two_point_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace opaline {
namespace {

TEST(RadialBasis, NodesAreEquallySpacedInLogDistanceAndReachPastTheLargest) {
  for (const double r_max : {0.002, 1.0, 37.0}) {
    const double r_0 = 0.01, spacing = 0.1;
    const RadialBasis basis(r_0, r_max, spacing);
    ASSERT_GE(basis.size(), 4);
    EXPECT_NEAR(basis.radius(0), 0, 1e-6 * r_0);
    for (int n = 0; n < basis.size(); ++n) {
      EXPECT_NEAR(std::log(std::hypot(basis.radius(n), r_0)), std::log(r_0) + n * spacing, 1e-12);
      EXPECT_NEAR(basis.weight(n) / std::pow(std::hypot(basis.radius(n), r_0), 1.5), 1, 1e-12);
    }
    EXPECT_GE(basis.radius(basis.size() - 2), r_max);
    if (basis.size() > 4) {
      EXPECT_LT(basis.radius(basis.size() - 4), r_max);
    }
  }
}

/// Cubic Lagrange weights on 0, 1, 2, 3 from their definition.
double lagrange(int j, double f) {
  double value = 1;
  for (int i = 0; i < 4; ++i)
    if (i != j) value *= (f - i) / (j - i);
  return value;
}

struct Landing {
  int first;
  double value[4];  ///< L_n(t) / w(x)
};

Landing landing(const RadialBasis& basis, double q) {
  const double x = q + basis.x_0(), u = (0.5 * std::log(x) - basis.t_0()) / basis.spacing();
  Landing out{std::clamp(static_cast<int>(u) - 1, 0, basis.size() - 4), {}};
  for (int j = 0; j < 4; ++j) out.value[j] = lagrange(j, u - out.first) / std::pow(x, 0.75);
  return out;
}

/// Largest error of the expansion of R relative to its largest value, both times w: so that plateau and tail count.
double expansion_error(const RadialBasis& basis, const Profile& profile, double r_max) {
  double worst = 0, largest = 0;
  for (double r = 1e-4; r < r_max; r *= 1.013) {
    const double weight = std::pow(r * r + basis.x_0(), 0.75);
    const Landing at = landing(basis, r * r);
    double sum = 0;
    for (int j = 0; j < 4; ++j) {
      const int n = at.first + j;
      sum += at.value[j] * basis.weight(n) * profile.evaluate(basis.radius(n));
    }
    worst = std::max(worst, weight * std::abs(sum - profile.evaluate(r)));
    largest = std::max(largest, weight * profile.evaluate(r));
  }
  return worst / largest;
}

TEST(RadialBasis, ExpandsTheDipoleOfMeasuredMaterials) {
  const double size = 35;  // the diameter of a box around a sphere of 10 mm radius
  const RadialBasis fine(2.5e-4 * size, size, 0.1), coarse(2.5e-4 * size, size, 0.4);
  int count = 0;
  double worst_coarse = 0;
  for (const MaterialRow& row : material_library()) {
    if (row.set != "jensen2001") continue;
    ++count;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto profile =
          find_profile("standard_dipole")->make(Medium<double>{row.sigma_a[c], row.sigma_s_prime[c], row.eta});
      EXPECT_LT(expansion_error(fine, *profile, size), 1e-4) << row.name << " channel " << c;
      worst_coarse = std::max(worst_coarse, expansion_error(coarse, *profile, size));
    }
  }
  EXPECT_EQ(count, 12);
  EXPECT_GT(worst_coarse, 1e-3);
}

/// Leaves with random moments: patches as any tree might hold them.
ClusterTree random_tree(std::size_t count, int masses, std::mt19937& random) {
  std::uniform_real_distribution<float> unit(0, 1), side(-1, 1);
  ClusterTree tree;
  tree.masses = masses;
  const auto width = static_cast<std::size_t>(masses);
  for (std::size_t i = 0; i < count; ++i) {
    ClusterNode node{};
    node.centroid = {3 * side(random), 3 * side(random), 3 * side(random)};
    if (i % 7 == 3) node.centroid = {0.01f * side(random), 0.5f, 0.25f};  // next to the query
    test::give_moments(node, 0.4f, [&] { return side(random); });
    tree.nodes.push_back(node);
    for (std::size_t m = 0; m < width; ++m) tree.mass.push_back(unit(random));
    if (masses > 1)
      for (std::size_t m = 0; m < 3 * width; ++m) tree.first_moment.push_back(0.05f * side(random));
  }
  return tree;
}

struct Sums {
  std::vector<double> value, magnitude;
};

/// The two-point rule: the flux goes to two values of q, shifted by the first moment of the channel.
void add_patch(const RadialBasis& basis, const ClusterTree& tree, std::size_t i, double weight,
               const glm::vec3& position, Sums& sums) {
  const test::TwoPointRule rule = test::two_point_rule(tree.nodes[i], position);
  const Landing near = landing(basis, rule.near), far = landing(basis, rule.far);
  const auto masses = static_cast<std::size_t>(tree.masses);
  for (std::size_t m = 0; m < masses; ++m) {
    double shift = 0;
    for (int axis = 0; axis < 3 && masses > 1; ++axis)
      shift += rule.d[axis] *
               static_cast<double>(tree.first_moment[(i * 3 + static_cast<std::size_t>(axis)) * masses + m]) /
               rule.spread;
    const double mass = static_cast<double>(tree.mass[i * masses + m]), share = rule.share_of_near;
    for (int j = 0; j < 4; ++j)
      for (const auto& [at, flux] :
           {std::pair(&near, share * mass + shift), std::pair(&far, (1 - share) * mass - shift)}) {
        const std::size_t to = static_cast<std::size_t>(at->first + j) * masses + m;
        sums.value[to] += weight * flux * at->value[j];
        // The nearer q is a difference of floats of the further one's size.
        const double condition = at == &near ? 1 + 0.1 * rule.far / (rule.near + basis.x_0()) : 1;
        sums.magnitude[to] += condition * std::abs(weight * flux * at->value[j]);
      }
  }
}

void compare(std::size_t count, int masses, bool weighted) {
  std::mt19937 random(static_cast<unsigned>(7 + count + 1000 * static_cast<std::size_t>(masses)));
  const RadialBasis basis(0.01, 9, 0.1);
  const ClusterTree tree = random_tree(count, masses, random);
  PatchList patches(masses);
  for (std::size_t i = 0; i < count; ++i) patches.push(tree, i);
  patches.pad();
  std::vector<float> weights(PatchList::padded(count), 1.0f);
  for (std::size_t i = 0; i < weights.size(); ++i) weights[i] = i % 3 == 1 ? 0.0f : 0.25f * static_cast<float>(i % 5);
  const glm::vec3 position(0.1f, 0.5f, 0.2f);
  const std::size_t size = static_cast<std::size_t>(basis.size() * masses);
  std::vector<float> found(size, 0.5f);  // deposits add to what is there
  deposit_patches(basis, patches, weighted ? weights.data() : nullptr, position, found.data());
  Sums sums{std::vector<double>(size, 0.5), std::vector<double>(size, 0.5)};
  for (std::size_t i = 0; i < count; ++i)
    add_patch(basis, tree, i, weighted ? static_cast<double>(weights[i]) : 1.0, position, sums);
  for (std::size_t k = 0; k < size; ++k)
    ASSERT_NEAR(static_cast<double>(found[k]), sums.value[k], 2e-5 * sums.magnitude[k])
        << count << " patches, " << masses << " masses, weighted " << weighted << ", entry " << k;
}

TEST(Deposit, AgreesWithTheRuleInDoubleOnEveryInstructionSet) {
  const std::vector<std::string> targets = simd_targets();
  ASSERT_FALSE(targets.empty());
  for (const std::string& target : targets) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(limit_simd_target(target));
    for (const int masses : {1, 3, 8, 24})
      for (const bool weighted : {false, true})
        for (const std::size_t count : {0u, 1u, 15u, 16u, 17u, 63u, 64u, 65u, 130u}) compare(count, masses, weighted);
  }
  limit_simd_target("");
}

/// The leaf as large as a part of it.
ClusterNode scaled(ClusterNode node, const glm::vec3& centroid, float scale) {
  node.centroid = centroid;
  for (float& c : node.covariance) c *= scale * scale;
  for (float& c : node.third) c *= scale * scale * scale;
  node.extent = node.extent.scaled(std::abs(scale));
  return node;
}

/// Runs of parts of every length around that of a vector, and of a chunk.
void compare_parts(int masses) {
  std::mt19937 random(static_cast<unsigned>(masses));
  std::uniform_real_distribution<float> side(-1, 1);
  const RadialBasis basis(0.01, 9, 0.1);
  const glm::vec3 position(0.1f, 0.5f, 0.2f);
  const std::size_t lengths[] = {1, 2, 7, 8, 15, 16, 17, 40, 63, 64, 65, 130, 1}, leaves = std::size(lengths);
  const ClusterTree tree = random_tree(leaves, masses, random);
  ClusterTree parts;  // as nodes of their own
  parts.masses = masses;
  DepositList list(masses);
  for (std::size_t leaf = 0; leaf < leaves; ++leaf)
    for (std::size_t i = 0; i < lengths[leaf]; ++i) {
      const float scale = (i % 3 == 1 ? -1.0f : 1.0f) / static_cast<float>(2 << i % 5);
      const glm::vec3 at = tree.nodes[leaf].centroid + 0.3f * glm::vec3(side(random), side(random), side(random));
      list.push_part(tree, static_cast<std::uint32_t>(leaf), at, scale);
      parts.nodes.push_back(scaled(tree.nodes[leaf], at, scale));
      for (int m = 0; m < masses; ++m)
        parts.mass.push_back(scale * scale *
                             tree.mass[leaf * static_cast<std::size_t>(masses) + static_cast<std::size_t>(m)]);
    }
  list.pad();
  parts.first_moment.assign(3 * parts.mass.size(), 0.0f);
  const std::size_t size = static_cast<std::size_t>(basis.size() * masses);
  std::vector<float> found(size, 0.5f);
  deposit_parts(basis, tree, list, position, found.data());
  Sums sums{std::vector<double>(size, 0.5), std::vector<double>(size, 0.5)};
  for (std::size_t i = 0; i < parts.nodes.size(); ++i) add_patch(basis, parts, i, 1, position, sums);
  for (std::size_t k = 0; k < size; ++k)
    ASSERT_NEAR(static_cast<double>(found[k]), sums.value[k], 2e-5 * sums.magnitude[k])
        << masses << " masses, entry " << k;
}

TEST(Deposit, OfPartsIsThatOfPatchesAsSmallOnEveryInstructionSet) {
  for (const std::string& target : simd_targets()) {
    SCOPED_TRACE(target);
    ASSERT_TRUE(limit_simd_target(target));
    for (const int masses : {1, 3, 8, 24}) compare_parts(masses);
  }
  limit_simd_target("");
}

}  // namespace
}  // namespace opaline
