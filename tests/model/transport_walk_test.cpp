#include "model/transport/walk.h"

#include "model/quadrature.h"
#include "model/simd.h"
#include "model/single_scattering/half_space.h"
#include "model/transport/check.h"
#include "model/transport/h_function.h"
#include "model/transport/reflectance_table.h"
#include "tests/model/transport_reference.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace opaline {
namespace {

using test::read_reference;

/// Deviation in standard errors.
double z_of(const Estimate& e, double expected, double expected_error = 0) {
  return (e.value - expected) / std::hypot(e.standard_error, expected_error);
}

#define EXPECT_AGREE(estimate, ...) \
  EXPECT_LT(std::abs(z_of(estimate, __VA_ARGS__)), 4) << (estimate).value << " +- " << (estimate).standard_error

/// Builds without optimisation (coverage, sanitizers) walk less; their errors are four times as large.
#ifdef __OPTIMIZE__
constexpr std::uint64_t fewer = 1;
constexpr double coarser = 1;
#else
constexpr std::uint64_t fewer = 16;
constexpr double coarser = 4;
#endif

WhiteWalk small_walk(double eta, double roulette_albedo, std::uint64_t walks = (1 << 20) / fewer) {
  WhiteWalk walk;
  walk.eta = eta;
  walk.roulette_albedo = roulette_albedo;
  walk.walks = walks;
  return walk;
}

bool same(const WalkCounts& a, const WalkCounts& b) {
  return a.reflected == b.reflected && a.transmitted == b.transmitted && a.killed == b.killed &&
         a.scatterings == b.scatterings;
}

TEST(ReflectanceTable, IsWithinItsStatedErrorOfTheFormula) {
  for (const double eta : {.4, .8, 1.01, 1.05, 1.1, 1.3, 1.5, 3.0}) {
    const double stated = eta == 1.01 ? 2.5e-5 : 6e-6;
    const std::vector<float> table = reflectance_table(eta);
    ASSERT_EQ(table.size(), reflectance_cells + 1u);
    for (double c = 0; c < 1; c += 1.7e-4) {
      const double t = c * reflectance_cells, f = t - std::floor(t);
      const auto i = static_cast<std::size_t>(t);
      const double linear = (1 - f) * double{table[i]} + f * double{table[i + 1]};
      EXPECT_NEAR(linear, fresnel_reflectance(c, std::max(eta, 1 / eta)), stated) << eta << " " << c;
    }
  }
}

TEST(Walk, PassesTheCheckAgainstPublishedAndExactTotals) {
  // Standard errors 1.5e-4 to 5e-4.
  for (const TransportCheckRow& row : transport_check(1000000 / fewer)) {
    EXPECT_LT(std::abs(row.z()), 4) << row.name << ": " << row.reached << " +- " << row.standard_error;
    EXPECT_LT(row.standard_error, 6e-4 * coarser) << row.name;
    EXPECT_GT(row.standard_error, 1e-5) << row.name;
  }
}

TEST(Walk, OneWalkPerEtaServesEveryAlbedoOfTheTable) {
  const auto table = read_reference("half_space_totals.csv");
  for (const double eta : {1.0, 1.3, 1.4, 1.5}) {
    const WalkCounts counts = white_walk(small_walk(eta, .995, 400000 / fewer));
    for (auto row : table) {
      if (row["eta"] != eta || row["alpha"] > .995) continue;
      const SearchlightResult r = searchlight_at(counts, row["alpha"]);
      EXPECT_AGREE(r.reflected, row["Rd_normal_per_transmitted"]) << eta << " " << row["alpha"];
      EXPECT_AGREE(r.reflected_per_incident(), row["Rd_normal_per_incident"]);
      EXPECT_AGREE(r.reflected_per_incident_with_specular(), row["Rtot_normal_with_specular"]);
      EXPECT_AGREE(r.once_reflected, row["R1_single_normal_per_transmitted"]);
      EXPECT_NEAR(r.specular, row["F0"], 1e-6);
    }
  }
}

TEST(Walk, GiovanellisHalfSpaceInThreeConventions) {
  // mu_a 1/mm, mu_s 9/mm, n 1.5 (Giovanelli 1955): 0.2600 with the specular 4 %.
  const SearchlightResult r = walk_half_space({{1, 9, 1.5}, 0, 1, {}, 2000000 / fewer, 5});
  EXPECT_AGREE(r.reflected, .229082);
  EXPECT_AGREE(r.reflected_per_incident(), .219919);
  EXPECT_AGREE(r.reflected_per_incident_with_specular(), .259919);
  EXPECT_LT(r.reflected.standard_error, 4e-4 * coarser);
  EXPECT_DOUBLE_EQ(r.specular, .04);
}

TEST(Walk, SlabInMillimetres) {
  // van de Hulst 1980 by the MCML manual: mu_a 10/cm, mu_s 90/cm, g .75, thickness .02 cm.
  const SearchlightResult r = walk_slab({{1, 9 * .25, 1}, .75, 1, {}, 2000000 / fewer, 3}, .2);
  EXPECT_AGREE(r.reflected, .09739);
  EXPECT_AGREE(r.transmitted, .66096);
  EXPECT_AGREE(r.unscattered_transmitted, std::exp(-2.0));
  EXPECT_EQ(r.unscattered_reflected.value, 0);
  EXPECT_AGREE(r.balance, 1);
}

TEST(Walk, AgreesWithAPlainScalarWalk) {
  const test::ScalarWalk cases[] = {{.9, 0, 1.5, 1.5, 1}, {.95, .7, 1.33, 3, .4}, {.6, -.5, .85, 1, .8}};
  for (const auto& k : cases) {
    const int walks = 300000 / int{fewer};
    const test::ScalarTotals expected = test::scalar_walk(k, walks, 11);
    WhiteWalk walk = small_walk(k.eta, k.albedo);
    walk.g = k.g;
    walk.optical_thickness = k.thickness;
    walk.cos_incident = k.cos_incident;
    const SearchlightResult r = searchlight_at(white_walk(walk), k.albedo);
    const auto error = [&](double share) { return std::sqrt(share * (1 - share) / walks); };
    EXPECT_AGREE(r.reflected, expected.reflected, error(expected.reflected)) << k.eta;
    EXPECT_AGREE(r.transmitted, expected.transmitted, error(expected.transmitted)) << k.eta;
    EXPECT_AGREE(r.absorbed, expected.absorbed, error(expected.absorbed)) << k.eta;
    EXPECT_NEAR(double(r.scatterings) / double(r.walks), double(expected.scatterings) / walks, .02 * coarser) << k.eta;
  }
}

TEST(Walk, UnscatteredLightBouncesBetweenTheFaces) {
  // Closed form: the geometric series of a plane-parallel plate with absorption.
  WhiteWalk walk = small_walk(1.8, 1);
  walk.optical_thickness = .7;
  const SearchlightResult r = searchlight_at(white_walk(walk), 0);
  const double f = fresnel_reflectance(1.0, 1.8), e = std::exp(-.7);
  EXPECT_AGREE(r.unscattered_transmitted, (1 - f) * e / (1 - f * f * e * e));
  EXPECT_AGREE(r.unscattered_reflected, (1 - f) * f * e * e / (1 - f * f * e * e));
  EXPECT_EQ(r.unscattered_reflected.value, r.reflected.value) << "an albedo of 0 leaves nothing else";
}

TEST(Walk, ThinSlabsKeepTheTrappedLight) {
  // Beyond the critical angle light leaves only by scattering again: hundreds of reflections a flight.
  const test::ScalarWalk k{.99, 0, 1.5, .05, 1};
  const int walks = 200000 / int{fewer};
  const test::ScalarTotals expected = test::scalar_walk(k, walks, 2);
  WhiteWalk walk = small_walk(k.eta, k.albedo);
  walk.optical_thickness = k.thickness;
  const SearchlightResult r = searchlight_at(white_walk(walk), k.albedo);
  EXPECT_AGREE(r.reflected, expected.reflected, std::sqrt(expected.reflected / walks));
  EXPECT_AGREE(r.transmitted, expected.transmitted,
               std::sqrt(expected.transmitted * (1 - expected.transmitted) / walks));
}

TEST(Walk, ConservesEnergyExactlyWithoutRoulette) {
  WhiteWalk walk = small_walk(1.4, 1, 100000);
  walk.optical_thickness = 3;
  walk.g = .4;
  const WalkCounts counts = white_walk(walk);
  for (const double albedo : {0.0, .3, .99, 1.0}) {
    const SearchlightResult r = searchlight_at(counts, albedo);
    EXPECT_NEAR(r.reflected.value + r.transmitted.value + r.absorbed.value, 1, 1e-11);
    EXPECT_NEAR(r.balance.value, 1, 1e-11);
    EXPECT_LT(r.balance.standard_error, 1e-8) << "walk by walk";
  }
}

TEST(Walk, ConservesEnergyInTheMeanWithRoulette) {
  for (const double roulette : {.5, .9, .99}) {
    WhiteWalk walk = small_walk(1.3, roulette);
    walk.free_scatterings = 3;
    const SearchlightResult r = searchlight_at(white_walk(walk), .95 * roulette);
    EXPECT_AGREE(r.balance, 1);
    EXPECT_NEAR(r.balance.value, r.reflected.value + r.absorbed.value, 1e-12);
  }
}

TEST(Walk, TheRouletteDoesNotMoveTheMean) {
  for (const std::uint32_t free : {0u, 1u, 7u, 40u}) {
    WhiteWalk walk = small_walk(1.5, .8, 300000 / fewer);
    walk.free_scatterings = free;
    walk.seed = free;
    const WalkCounts counts = white_walk(walk);
    for (const double albedo : {.2, .8, .85})
      EXPECT_AGREE(searchlight_at(counts, albedo).reflected, half_space_albedo(albedo, 1.5).beam_per_transmitted)
          << free << " " << albedo;
  }
}

TEST(Walk, StandardErrorsDescribeTheScatterOfRuns) {
  const int runs = 200;
  double sum = 0, squares = 0, stated = 0;
  for (int i = 0; i < runs; ++i) {
    WhiteWalk walk = small_walk(1.3, .95, 4000);
    walk.seed = 1000u + static_cast<unsigned>(i);
    const Estimate e = searchlight_at(white_walk(walk), .7).reflected;
    sum += e.value;
    squares += e.value * e.value;
    stated += e.standard_error * e.standard_error / runs;
  }
  const double variance = (squares - sum * sum / runs) / (runs - 1);
  EXPECT_NEAR(variance / stated, 1, 4 * std::sqrt(2.0 / runs));
}

TEST(Walk, EscapeFollowsTheTailLaw) {
  // Unit albedo: the share not escaped after n scatterings goes to C/sqrt(pi n), C = lim (1 - R)/sqrt(1 - albedo),
  // which is H(1) at eta = 1; the next term is of relative order 1/n. A cap at 256 would lose 10 to 20 %.
  for (const double eta : {1.0, 1.5}) {
    WhiteWalk walk = small_walk(eta, .5, 50000);
    walk.free_scatterings = 4096;
    const WalkCounts counts = white_walk(walk);
    const double epsilon = 1e-8;
    const double c = (1 - half_space_albedo(1 - epsilon, eta).beam_per_transmitted) / std::sqrt(epsilon);
    if (eta == 1) {
      EXPECT_NEAR(c, chandrasekhar_h(1, 1), 1e-3);
    }
    double left = static_cast<double>(counts.walks);
    for (std::size_t n = 0, check = 256; n <= 4096; ++n) {
      left -= static_cast<double>(counts.reflected[n]);
      if (n != check) continue;
      const double share = left / static_cast<double>(counts.walks), law = c / std::sqrt(pi * double(n));
      const double error = std::sqrt(law / static_cast<double>(counts.walks));
      EXPECT_NEAR(share, law, 4 * error + 5 * law / double(n)) << eta << " " << n;
      check *= 4;
    }
  }
}

std::vector<double> reference_radii() {
  return {0, .01, .02, .05, .1, .2, .3, .5, .75, 1, 1.5, 2, 3, 4, 5, 7, 10, 15, 20, 30, 50};
}

TEST(Walk, SearchlightProfilesMatchTheTable) {
  const auto table = read_reference("searchlight_profiles.csv");
  for (const double eta : {1.0, 1.3}) {
    WhiteWalk walk = small_walk(eta, .99, (3 << 20) / fewer);
    walk.radii = reference_radii();
    const WalkCounts counts = white_walk(walk);
    for (const double albedo : {.5, .8, .9, .95, .99}) {
      const SearchlightResult r = searchlight_at(counts, albedo);
      double squares = 0;
      int compared = 0;
      for (auto row : table) {
        if (row["eta"] != eta || row["alpha"] != albedo) continue;
        for (const AnnulusEstimate& a : r.reflectance) {
          if (a.inner != row["r_lo"] || a.exitance.standard_error > .05 * a.exitance.value) continue;
          const double z = z_of(a.exitance, row["R"], row["R"] * row["se_pct"] / 100);
          EXPECT_LT(std::abs(z), 4) << eta << " " << albedo << " r " << a.inner << ": " << a.exitance.value;
          squares += z * z;
          ++compared;
        }
      }
      EXPECT_GT(compared, 10);
      EXPECT_LT(squares / compared, 2.2) << eta << " " << albedo;
    }
  }
}

TEST(Walk, SingleScatteringIsTheClosedForm) {
  for (const double eta : {1.0, 1.4})
    for (const double g : {0.0, .6}) {
      WhiteWalk walk = small_walk(eta, .5, (3 << 20) / fewer);
      walk.g = g;
      walk.radii = {.02, .1, .3, .7, 1.5};
      const SearchlightResult r = searchlight_at(white_walk(walk), .5);
      const ScatteringMedium<double> medium{.5, .5, g, eta};
      EXPECT_AGREE(r.once_reflected, single_scattering_total(medium));
      for (const AnnulusEstimate& a : r.reflectance) {
        const auto ring = [&](double x) { return 2 * pi * x * single_scattering_profile(medium, x); };
        const double area = pi * (a.outer * a.outer - a.inner * a.inner);
        EXPECT_AGREE(a.once, gauss_legendre(a.inner, a.outer, ring) / area) << eta << " " << g << " " << a.inner;
      }
    }
}

TEST(Walk, AnnuliHoldAllThatIsScattered) {
  WhiteWalk walk = small_walk(1.3, .9, 200000);
  walk.radii = {0, .1, 1, 10, 1e6};
  walk.optical_thickness = 2;
  const SearchlightResult r = searchlight_at(white_walk(walk), .9);
  const auto flux = [](const std::vector<AnnulusEstimate>& annuli) {
    double sum = 0;
    for (const AnnulusEstimate& a : annuli) sum += a.exitance.value * pi * (a.outer * a.outer - a.inner * a.inner);
    return sum;
  };
  ASSERT_EQ(r.reflectance.size(), 4u);
  EXPECT_NEAR(flux(r.reflectance), r.reflected.value - r.unscattered_reflected.value, 1e-12);
  EXPECT_NEAR(flux(r.transmittance), r.transmitted.value - r.unscattered_transmitted.value, 1e-12);
}

TEST(Walk, TransmittedSingleScatteringIsTheClosedForm) {
  // Matched slab of thickness b, isotropic: (albedo/2) int_0^b e^-t int_0^1 e^{-(b-t)/mu} dmu dt.
  WhiteWalk walk = small_walk(1, .5);
  walk.optical_thickness = 1.2;
  const double b = walk.optical_thickness;
  const double expected =
      .25 * gauss_legendre(0.0, 1.0, [&](double s) {
        const double t = b * (1 - s * s);  // towards the far face, where the inner integral bends
        return 2 * b * s * gauss_legendre(0.0, 1.0, [&](double mu) { return std::exp(-t - (b - t) / mu); });
      });
  EXPECT_AGREE(searchlight_at(white_walk(walk), .5).once_transmitted, expected);
}

TEST(Walk, PhaseFunctionMovesLightOutwards) {
  // R(r) over that of g = 0 at equal alpha' = .9, eta 1.3 (science notes, B.5: three decimals by Monte-Carlo).
  const std::vector<double> radii = {.1, .2, .5, .75, 1.5, 2, 3};
  const auto at = [&](double g, std::uint64_t seed) {
    return walk_half_space({{.1, .9, 1.3}, g, 1, radii, 2000000 / fewer, seed}).reflectance;
  };
  const auto none = at(0, 8);
  const struct {
    double g, near, middle, far;
  } table[] = {{.5, .629, .923, 1.181}, {.8, .489, .873, 1.269}, {-.3, 1.474, 1.103, .815}};
  for (const auto& row : table) {
    const auto some = at(row.g, 9);
    const auto compare = [&](std::size_t i, double expected) {
      const Estimate &a = some[i].exitance, &b = none[i].exitance;
      const double ratio = a.value / b.value;
      const double error = ratio * std::hypot(a.standard_error / a.value, b.standard_error / b.value);
      EXPECT_LT(error, .013 * coarser);
      EXPECT_AGREE((Estimate{ratio, error}), expected, .002 * expected) << row.g << " " << radii[i];
    };
    compare(0, row.near);
    compare(2, row.middle);
    compare(5, row.far);
  }
}

TEST(Walk, FarAwayOnlyTheReducedCoefficientsMatter) {
  // Similarity: beyond several transport mean free paths g .3 looks like g 0 within some percent; near it does not.
  const std::vector<double> radii = {.05, .1, 5, 10};
  const auto at = [&](double g) {
    return walk_half_space({{.02, .98, 1}, g, 1, radii, 4000000 / fewer, 8}).reflectance;
  };
  const auto none = at(0), some = at(.3);
  EXPECT_NEAR(some[2].exitance.value / none[2].exitance.value, 1, .06 * coarser);
  EXPECT_LT(some[0].exitance.value / none[0].exitance.value, .85);
}

TEST(Walk, ScalesWithTheUnitOfLength) {
  Searchlight light{{.25, 2, 1.4}, .5, .7, {.125, .5, 2}, 50000, 4};
  const SearchlightResult a = walk_slab(light, 3);
  light.medium = {.5, 4, 1.4};
  light.radii = {.0625, .25, 1};
  const SearchlightResult b = walk_slab(light, 1.5);
  EXPECT_EQ(a.reflected.value, b.reflected.value);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(b.reflectance[i].inner, a.reflectance[i].inner / 2);
    EXPECT_EQ(b.reflectance[i].exitance.value, 4 * a.reflectance[i].exitance.value);
    EXPECT_EQ(b.transmittance[i].exitance.standard_error, 4 * a.transmittance[i].exitance.standard_error);
  }
}

TEST(Walk, TheSameSeedGivesTheSameBitsForAnyNumberOfThreads) {
  WhiteWalk walk = small_walk(1.3, .9, 500000);
  walk.radii = reference_radii();
  walk.optical_thickness = 10;
  const WalkCounts reference = white_walk(walk);
  for (const std::size_t threads : {1u, 2u, 5u}) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    EXPECT_TRUE(same(white_walk(walk), reference)) << threads;
  }
  walk.seed = 2;
  EXPECT_FALSE(same(white_walk(walk), reference));
}

TEST(Walk, CountsEveryWalkOnce) {
  for (const std::uint64_t walks : {1u, 7u, 65u, 65536u, 65537u, 200001u}) {
    const WalkCounts counts = white_walk(small_walk(1.4, .7, walks));
    std::uint64_t ends = 0;
    for (const auto c : counts.reflected) ends += c;
    for (const auto c : counts.killed) ends += c;
    EXPECT_EQ(ends, walks);
    EXPECT_EQ(counts.walks, walks);
  }
}

TEST(Walk, EveryVectorTargetGivesTheSamePhysics) {
  struct NoLimitAfterwards {
    ~NoLimitAfterwards() { limit_simd_target(""); }
  } guard;
  for (const std::string& target : simd_targets()) {
    ASSERT_TRUE(limit_simd_target(target));
    WhiteWalk walk = small_walk(1.4, .9, 500000 / fewer);
    EXPECT_AGREE(searchlight_at(white_walk(walk), .9).reflected, half_space_albedo(.9, 1.4).beam_per_transmitted)
        << target;
    walk.g = .5;
    const double albedo = 18.0 / 19;  // alpha' = .9
    walk.eta = 1.3;
    walk.roulette_albedo = albedo;
    EXPECT_AGREE(searchlight_at(white_walk(walk), albedo).reflected, .27940, 1e-4) << target;
  }
}

TEST(Annuli, FindTheBinThatASearchFinds) {
  const Annuli annuli({.001, .01, .010001, .5, .7, 3, 1000});
  ASSERT_EQ(annuli.bins(), 7u);
  const auto& radii = annuli.radii();
  for (double r = 1e-4; r < 5000; r *= 1.003) {
    const auto r2 = static_cast<float>(r * r);
    std::size_t expected = 6;
    for (std::size_t i = 0; i + 1 < radii.size(); ++i)
      if (r2 >= static_cast<float>(radii[i] * radii[i]) && r2 < static_cast<float>(radii[i + 1] * radii[i + 1]))
        expected = i;
    EXPECT_EQ(annuli.bin(r2), expected) << r;
  }
  EXPECT_EQ(annuli.bin(0), 6u);
  EXPECT_EQ(Annuli({0, 1}).bin(0), 0u);
  EXPECT_EQ(Annuli().bin(5), 0u);
}

TEST(Walk, RefusesWhatMakesNoSense) {
  const auto refused = [](auto change) {
    WhiteWalk walk;
    walk.walks = 10;
    change(walk);
    EXPECT_THROW(white_walk(walk), std::invalid_argument);
  };
  refused([](WhiteWalk& w) { w.g = 1; });
  refused([](WhiteWalk& w) { w.eta = 0; });
  refused([](WhiteWalk& w) { w.optical_thickness = 0; });
  refused([](WhiteWalk& w) { w.roulette_albedo = 1; });
  refused([](WhiteWalk& w) { w.cos_incident = 0; });
  refused([](WhiteWalk& w) { w.eta = .5, w.cos_incident = .2; });
  refused([](WhiteWalk& w) { w.radii = {2, 1}; });
  refused([](WhiteWalk& w) { w.walks = 0; });
  EXPECT_THROW(walk_half_space({{0, 1, 1.3}, 0, 1, {}, 10, 1}), std::invalid_argument) << "no absorption: endless";
  EXPECT_THROW(walk_half_space({{1, 0, 1.3}, 0, 1, {}, 10, 1}), std::invalid_argument);
  EXPECT_THROW(searchlight_at(white_walk(small_walk(1, .5, 10)), 1.5), std::invalid_argument);
}

}  // namespace
}  // namespace opaline
