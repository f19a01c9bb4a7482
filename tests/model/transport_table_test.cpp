// The profile transport_table against its solver, exact totals, independent walks and its own tail.
#include "model/profiles/transport_table.h"

#include "model/profiles/model_error.h"
#include "model/profiles/profile.h"
#include "model/single_scattering/half_space.h"
#include "model/transport/h_function.h"
#include "model/transport/searchlight_mixture.h"
#include "model/transport/transport_table_maker.h"
#include "model/transport/walk.h"
#include "tests/model/transport_reference.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace opaline {
namespace {

/// Lengths in transport mean free paths.
std::unique_ptr<Profile> table(double albedo, double eta) {
  return find_profile("transport_table")->make({1 - albedo, albedo, eta});
}

TEST(TransportTable, ScattersOnceExactly) {
  for (const double eta : {1.0, 1.0003, 1.03, 1.3, 2.0}) {
    const OnceScattered<double> once(eta);
    const ScatteringMedium<double> medium{0, 1, 0, eta};
    for (double r = 2e-4; r < 11; r *= 1.7) {
      EXPECT_NEAR(once.evaluate(r) / single_scattering_profile(medium, r), 1, 3e-5) << eta << " " << r;
      EXPECT_NEAR(once.cumulative(r) / single_scattering_cumulative(medium, r), 1, 1e-6) << eta << " " << r;
    }
  }
}

/// Media between the table's nodes, made anew.
TEST(TransportTable, IsWhatItsMakerFinds) {
  const std::array<double, 4> albedos = {.2, .55, .93, .9998};
  for (const double eta : {1.0, 1.27}) {
    const auto mixtures = searchlight_mixtures(eta, albedos);
    for (std::size_t i = 0; i < albedos.size(); ++i) {
      const double albedo = albedos[i];
      const auto profile = table(albedo, eta);
      const double last = std::min(100.0, .7 * TransportTableShape::reach(1 - albedo));
      for (double r = .01; r < last; r *= 1.37) {
        const double once = single_scattering_profile(ScatteringMedium<double>{1 - albedo, albedo, 0, eta}, r);
        const double exact = once + std::exp(mixtures[i].log_evaluate(r)),
                     beyond = profile->total() - profile->cumulative(r);
        // 0.3 % is asked for until what lies beyond is 1e-6 of the total.
        const double limit = beyond > 1e-6 * profile->total() ? (r < .02 ? 5e-4 : 2e-4) : 2e-2;
        EXPECT_NEAR(profile->evaluate(r) / exact, 1, limit) << eta << " " << albedo << " " << r;
      }
    }
  }
}

TEST(TransportTable, HasTheExactTotals) {
  double worst = 0;
  for (const double eta : {1.0, 1.013, 1.1, 1.3, 1.33, 1.5, 1.77, 2.0}) {
    for (const double albedo : {.03, .2, .45, .7, .9, .97, .993, .9999, 1.0}) {
      const double exact = albedo == 1 ? 1 : half_space_albedo(albedo, eta).beam_per_transmitted;
      const double error = table(albedo, eta)->total() / exact - 1;
      EXPECT_LT(std::abs(error), 1e-4) << eta << " " << albedo;
      worst = std::max(worst, std::abs(error));
    }
  }
  EXPECT_GT(worst, 1e-9);
}

/// This project's walks, which share nothing with the maker.
TEST(TransportTable, AgreesWithWalks) {
  WhiteWalk walk;
  walk.eta = 1.4;
  walk.walks = 2000000;
  walk.roulette_albedo = .97;
  walk.radii = {.01, .02, .05, .1, .2, .4, .7, 1, 1.5, 2, 3, 4, 6, 8, 11, 15};
  const WalkCounts counts = white_walk(walk);
  for (const double albedo : {.35, .8, .97}) {
    const auto profile = table(albedo, walk.eta);
    const SearchlightResult r = searchlight_at(counts, albedo);
    EXPECT_LT(std::abs(r.reflected.value - profile->total()) / r.reflected.standard_error, 4) << albedo;
    for (const AnnulusEstimate& a : r.reflectance) {
      if (a.exitance.standard_error > .1 * a.exitance.value) continue;  // too few walks for Gauss's law
      const double area = pi * (a.outer - a.inner) * (a.outer + a.inner);
      const double mean = (profile->cumulative(a.outer) - profile->cumulative(a.inner)) / area;
      EXPECT_LT(std::abs(a.exitance.value - mean) / a.exitance.standard_error, 4) << albedo << " " << a.inner;
    }
  }
}

/// exp(-r/v0)/r^2 far out; v0 from the science notes, table B.2.
TEST(TransportTable, DecaysWithTheExactExponent) {
  const double table_b2[][2] = {{.3, 1.002592889}, {.5, 1.044382034}, {.9, 1.903204856}, {.99, 5.796729451}};
  for (const auto& [albedo, v0] : table_b2) {
    for (const double eta : {1.0, 1.5}) {
      const auto profile = table(albedo, eta);
      const double a = 120 * v0, b = 240 * v0;
      const double slope = std::log(profile->evaluate(b) * b * b / (profile->evaluate(a) * a * a)) / (b - a);
      EXPECT_NEAR(-slope * v0, 1, 2e-4) << albedo;
    }
  }
}

TEST(TransportTable, WithoutAbsorptionItFallsLikeTheCube) {
  const auto profile = table(1, 1.3);
  EXPECT_NEAR(profile->evaluate(2e4) / profile->evaluate(4e4), 8, 1e-3);
  EXPECT_NEAR(profile->total(), 1, 1e-4);
}

TEST(TransportTable, HoldsAnEtaOutsideItsDomain) {
  for (const auto& [outside, end] : {std::pair{.5, 1.0}, {.999, 1.0}, {2.01, 2.0}, {3.0, 2.0}}) {
    const ProfileGradient held = table(.9, outside)->evaluate_with_gradient(.7);
    EXPECT_EQ(held.value, table(.9, end)->evaluate_with_gradient(.7).value);
    EXPECT_EQ(held.d_eta, 0);
  }
  EXPECT_EQ(table(0, 1.3)->total(), 0);
  EXPECT_EQ(table(0, 1.3)->evaluate(0), 0);
}

/// At the ends, where square roots lurk: one-sided differences over small steps.
TEST(TransportTable, HasFiniteDerivativesAtTheEnds) {
  const auto value = [](double a, double eta, double r) {
    return find_profile("transport_table")->make({a, 1, eta})->evaluate(r);
  };
  for (const double r : {.05, 1.0, 10.0}) {
    const ProfileGradient g = table(1, 1)->evaluate_with_gradient(r);
    const double h = 1e-8, by_absorption = (value(h, 1, r) - value(0, 1, r)) / h;
    EXPECT_NEAR(g.d_sigma_a / by_absorption, 1, 1e-2) << r;
    const double k = 1e-6, by_eta = (value(0, 1 + k, r) - value(0, 1, r)) / k;
    EXPECT_NEAR(g.d_eta / by_eta, 1, 2e-2) << r;
  }
}

TEST(TransportTable, ShowsTheKnownErrorsOfDipoles) {
  const ModelError dipole = model_error(*find_profile("standard_dipole"), .5, 1);
  // Totals of the science notes, B.4: 0.115226 exact; the dipole's closed form A.1 has A = 1.
  const double s = std::sqrt(1.5), closed = .25 * (1 + std::exp(-4.0 / 3 * s)) * std::exp(-s);
  EXPECT_NEAR(dipole.total, closed / .115226 - 1, 2e-5);
  const ModelError none = model_error(*find_profile("transport_table"), .9, 1.3);
  EXPECT_EQ(none.total, 0);
  EXPECT_EQ(none.shape, 0);
  EXPECT_GE(dipole.shape, std::abs(dipole.bias));
}

}  // namespace
}  // namespace opaline
