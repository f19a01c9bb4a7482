#include "model/profiles/dipole_batch.h"

#include "model/materials/library.h"
#include "model/simd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace opaline {
namespace {

using Dipole = StandardDipole<double>;

struct NoLimitAfterwards {
  ~NoLimitAfterwards() { limit_simd_target(""); }
};

std::vector<float> batch(const Dipole (&rgb)[3], const std::vector<float>& r2, std::size_t channel) {
  std::vector<float> values[3];
  for (auto& v : values) v.resize(r2.size());
  evaluate_dipoles_rgb(rgb, r2.data(), r2.size(), {values[0].data(), values[1].data(), values[2].data()});
  return values[channel];
}

/// Every lane against the scalar formula, by the promise in the header.
void expect_as_promised(const Dipole (&rgb)[3], const std::vector<float>& r2, const std::string& target) {
  for (std::size_t c = 0; c < 3; ++c) {
    const std::vector<float> values = batch(rgb, r2, c);
    for (std::size_t i = 0; i < r2.size(); ++i) {
      const double q = static_cast<double>(r2[i]), exact = rgb[c].evaluate_squared(q),
                   got = static_cast<double>(values[i]);
      ASSERT_TRUE(std::isfinite(got) && got >= 0) << target << " r2 " << q << " z_r " << rgb[c].z_r;
      const double exponent = rgb[c].sigma_tr * std::sqrt(q + rgb[c].z_v * rgb[c].z_v);
      if (exponent < 85 && exact > 1e-36) {
        ASSERT_NEAR(got, exact, 1e-6 * exact) << target << " r2 " << q << " z_r " << rgb[c].z_r << " y " << exponent;
      } else {
        ASSERT_LE(got, 1.000001 * exact + 1e-37) << target << " r2 " << q;
      }
    }
  }
}

/// 0, the largest float, and logarithmic radii from 1e-6 to 1e9 depths.
std::vector<float> wide_squares(double depth, std::mt19937& random, std::size_t count) {
  std::uniform_real_distribution<double> exponent(-6, 9);
  std::vector<float> r2 = {0.0f, 1e-38f, 3e38f};
  while (r2.size() < count)
    r2.push_back(static_cast<float>(std::min(3e38, std::pow(depth * std::pow(10, exponent(random)), 2))));
  return r2;
}

// Measured: 6.8e-7 on every target.
TEST(DipoleBatch, EveryLaneOfEveryInstructionSetAgreesWithTheScalarFormula) {
  const NoLimitAfterwards guard;
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> decades(-6, 6), absorbed(-12, 0), eta(0.5, 3);
    for (int k = 0; k < 300; ++k) {
      Medium<double> m[3];
      for (auto& medium : m) {
        const double sigma_t = std::pow(10, decades(random)), share = k % 5 ? std::pow(10, absorbed(random)) : 0;
        medium = {sigma_t * share, sigma_t * (1 - share), eta(random)};
      }
      const Dipole rgb[3] = {Dipole(m[0]), Dipole(m[1]), Dipole(m[2])};
      expect_as_promised(rgb, wide_squares(rgb[k % 3].z_r, random, 150), target);
    }
  }
}

TEST(DipoleBatch, HoldsForTheMaterialsOfTheLibrary) {
  const NoLimitAfterwards guard;
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    std::mt19937 random(2);
    for (const MaterialRow& row : material_library()) {
      const auto dipole = [&](std::size_t c) { return Dipole({row.sigma_a[c], row.sigma_s_prime[c], row.eta}); };
      const Dipole rgb[3] = {dipole(0), dipole(1), dipole(2)};
      expect_as_promised(rgb, wide_squares(rgb[0].z_r, random, 64), target);
    }
  }
}

TEST(DipoleBatch, HoldsInTheCornersOfItsDomain) {
  const NoLimitAfterwards guard;
  const std::vector<float> r2 = {0, 1e-38f, 1e-18f, 1, 1e18f, 1e36f, 3e38f};
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    for (const double sigma_t : {1e-8, 1.0, 1e9})
      for (const double share : {0.0, 1e-300, 1e-15, 1e-9, 0.5, 1.0 - 1e-15, 1.0})
        for (const double eta : {0.5, 1.0, 3.0}) {
          const Dipole one({sigma_t * share, sigma_t * (1 - share), eta});
          expect_as_promised({one, one, one}, r2, target);
        }
    Dipole opaque({1, 1, 1.3});  // a sigma_tr far beyond what a medium can have
    opaque.sigma_tr = 1e9 / opaque.z_r, opaque.sigma_tr_squared = opaque.sigma_tr * opaque.sigma_tr;
    expect_as_promised({opaque, opaque, opaque}, r2, target);
  }
}

TEST(DipoleBatch, TakesAnyNumberOfDistancesAndWritesNoFurther) {
  const NoLimitAfterwards guard;
  const Dipole rgb[3] = {Dipole({0.1, 1, 1.3}), Dipole({0.2, 1, 1.3}), Dipole({0.3, 1, 1.3})};
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    for (const std::size_t n : {0u, 1u, 7u, 16u, 31u, 32u, 33u, 100u}) {
      std::vector<float> r2(n), values[3];
      for (std::size_t i = 0; i < n; ++i) r2[i] = static_cast<float>(i) * 0.1f;
      for (auto& v : values) v.assign(n + 1, -1.0f);
      evaluate_dipoles_rgb(rgb, r2.data(), n, {values[0].data(), values[1].data(), values[2].data()});
      for (std::size_t c = 0; c < 3; ++c) {
        EXPECT_EQ(values[c][n], -1.0f);
        for (std::size_t i = 0; i < n; ++i) {
          const double exact = rgb[c].evaluate_squared(static_cast<double>(r2[i]));
          EXPECT_NEAR(values[c][i], exact, 1e-6 * exact) << target << " " << n;
        }
      }
    }
  }
}

}  // namespace
}  // namespace opaline
