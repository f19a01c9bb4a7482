// The deterministic searchlight problem: H functions of wave numbers, the transform, the sum of Yukawa terms.
#include "model/transport/searchlight_mixture.h"

#include "model/single_scattering/half_space.h"
#include "model/transport/asymptotic_decay.h"
#include "model/transport/h_function.h"
#include "model/transport/modulated_h.h"
#include "model/transport/searchlight_transform.h"
#include "tests/model/transport_reference.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace opaline {
namespace {

double once_total(double albedo, double eta) {
  return single_scattering_total(ScatteringMedium<double>{1 - albedo, albedo, 0, eta});
}

TEST(AsymptoticDecay, IsTheTabulatedOne) {
  // v0 to ten digits, science notes B.2 (Chandrasekhar half space).
  const double table[][2] = {{.2, 1.000090887}, {.3, 1.002592889},  {.5, 1.044382034},   {.8, 1.407634309},
                             {.9, 1.903204856}, {.99, 5.796729451}, {.999, 18.26472573}, {.9999, 57.73733645}};
  for (const auto& [albedo, v0] : table) {
    EXPECT_NEAR(1 / std::sqrt(asymptotic_decay_squared(1 - albedo)), v0, 6e-10 * v0) << albedo;
  }
}

TEST(AsymptoticDecay, SolvesItsEquationWithExactDerivatives) {
  using Dual = ceres::Jet<double, 1>;
  for (const double absorbed : {0.0, 1e-300, 1e-15, 1e-10, 3e-9, 1e-6, 1e-3, 3.3e-3, .1, .5, .9, .939}) {
    const Dual w = asymptotic_decay_squared(Dual(absorbed, 0));
    EXPECT_GE(w.a, 0) << absorbed;
    if (absorbed < 1e-6) {
      EXPECT_NEAR(w.a, 3 * absorbed * (1 - .8 * absorbed), 1e-13 * w.a) << absorbed;
      EXPECT_NEAR(w.v[0], 3, 1e-5) << absorbed;
      continue;
    }
    const double k = std::sqrt(w.a), reach = std::atanh(k) / k;
    // (1 - a) A(w) = 1, so dw/da = A^2/A'. Near w = 1 a rounding of w shows in A.
    const double slope = (1 / (1 - w.a) - reach) / (2 * w.a), rounding = 1e-15 / (1 - w.a);
    EXPECT_NEAR((1 - absorbed) * reach, 1, 1e-14 + rounding) << absorbed;
    EXPECT_NEAR(w.v[0], reach * reach / slope, (1e-7 + rounding) * w.v[0]) << absorbed;
  }
  for (const double absorbed : {.95, .999, 1.0}) EXPECT_EQ(asymptotic_decay_squared(absorbed), 1);
}

TEST(ModulatedH, IsChandrasekharsWithoutModulation) {
  for (auto row : test::read_reference("h_function.csv")) {
    const ModulatedH h(row["alpha"], 0);
    EXPECT_NEAR(1 + h.minus_one(1).real(), row["H1"], 1e-9 * row["H1"]) << row["alpha"];
    EXPECT_NEAR(1 + h.minus_one(.3).real(), chandrasekhar_h(row["alpha"], .3), 1e-11) << row["alpha"];
  }
}

/// Its factorisation: H(x) H(-x) Lambda(x) = 1; on the imaginary axis, x = i/tau, Lambda = 1 - albedo atan(q)/q with
/// q^2 = tau^2 + k^2, and H(-x) is the conjugate.
TEST(ModulatedH, FactorsTheDispersionFunction) {
  for (const double albedo : {.3, .9, 1.0}) {
    for (const double k_squared : {-.2 * (albedo < .95), 0.01, 1.0, 900.0}) {
      const ModulatedH h(albedo, k_squared);
      for (const double tau : {.01, .3, 1.0, 7.0, 200.0}) {
        const std::complex<double> value = 1.0 + h.minus_one({1e-13, 1 / tau});
        const std::complex<double> q = std::sqrt(std::complex<double>(tau * tau + k_squared));
        const double lambda = 1 - albedo * (std::atan(q) / q).real();
        EXPECT_NEAR(std::norm(value) * lambda, 1, 1e-7) << albedo << " " << k_squared << " " << tau;
      }
    }
  }
}

TEST(SearchlightTransform, HasTheExactTotals) {
  for (const double eta : {1.0, 1.0001, 1.02, 1.3, 2.0}) {
    const std::array<double, 5> albedos = {.01, .3, .9, .999, 1.0};
    const std::vector<double> multiple = searchlight_transform(0, eta, albedos);
    for (std::size_t i = 0; i < albedos.size(); ++i) {
      const double exact = half_space_albedo(albedos[i], eta).beam_per_transmitted - once_total(albedos[i], eta);
      EXPECT_NEAR(multiple[i], exact, 3e-8 * exact + 4e-9) << eta << " " << albedos[i];
    }
  }
}

TEST(SearchlightTransform, ConvergesWithItsRules) {
  struct Row {
    double k_squared, limit;
  };
  for (const double eta : {1.0, 1.3, 1.8}) {
    for (const Row& row : {Row{-.25, 1e-8}, {.01, 3e-8}, {1, 3e-8}, {100, 3e-6}, {2500, 1e-4}}) {
      const std::array<double, 1> albedo = {.8};
      const double value = searchlight_transform(row.k_squared, eta, albedo)[0];
      const double finer = searchlight_transform(row.k_squared, eta, albedo, 1.8)[0];
      EXPECT_NEAR(value, finer, row.limit * finer) << eta << " " << row.k_squared;
      EXPECT_NE(value, finer);
    }
  }
}

/// The fit knows the transform at some wave numbers; here it is asked at others, on both sides of zero.
TEST(SearchlightMixture, HasTheTransformBetweenTheWaveNumbersItWasFittedAt) {
  const std::array<double, 2> albedos = {.4, .99};
  const double eta = 1.4;
  const auto mixtures = searchlight_mixtures(eta, albedos);
  for (std::size_t i = 0; i < albedos.size(); ++i) {
    EXPECT_LT(mixtures[i].residual, 30) << "in units of 1e-9";
    const double edge = mixtures[i].decay * mixtures[i].decay;
    for (const double k_squared : {-.85 * edge, -.4 * edge, .0007, .04, .9, 7.0, 60.0, 3000.0}) {
      const double exact = searchlight_transform(k_squared, eta, std::span(&albedos[i], 1))[0];
      const double limit = 3e-6 + 3e-9 * std::pow(std::max(k_squared, 0.0), 1.25);
      EXPECT_NEAR(mixtures[i].transform(k_squared), exact, limit * exact) << albedos[i] << " " << k_squared;
    }
    for (const auto& term : mixtures[i].terms) {
      EXPECT_GT(term.weight, 0);
      EXPECT_GE(term.kappa, mixtures[i].decay);
    }
  }
}

/// Another program's Monte-Carlo walks; their standard errors, and half a unit of the last digit printed.
TEST(SearchlightMixture, AgreesWithIndependentWalks) {
  const std::array<double, 6> albedos = {.5, .8, .9, .95, .99, .999};
  std::map<double, std::vector<SearchlightMixture>> mixtures;
  for (const double eta : {1.0, 1.3}) mixtures[eta] = searchlight_mixtures(eta, albedos);
  double chi_squared = 0, count = 0;
  for (auto row : test::read_reference("searchlight_profiles.csv")) {
    const double eta = row["eta"], albedo = row["alpha"];
    const auto i = std::ranges::find(albedos, albedo) - albedos.begin();
    const SearchlightMixture& mixture = mixtures.at(eta).at(static_cast<std::size_t>(i));
    const ScatteringMedium<double> medium{1 - albedo, albedo, 0, eta};
    const double lo = row["r_lo"], hi = row["r_hi"], area = pi * (hi - lo) * (hi + lo);
    const double flux = mixture.flux_between(lo, hi) + single_scattering_cumulative(medium, hi) -
                        (lo > 0 ? single_scattering_cumulative(medium, lo) : 0);
    const double error = std::hypot(.01 * row["se_pct"], 3e-5) * row["R"], z = (flux / area - row["R"]) / error;
    EXPECT_LT(std::abs(z), 4) << eta << " " << albedo << " " << lo;
    chi_squared += z * z;
    count += 1;
  }
  EXPECT_GT(count, 200);
  EXPECT_LT(std::abs(chi_squared - count) / std::sqrt(2 * count), 4);
}

}  // namespace
}  // namespace opaline
