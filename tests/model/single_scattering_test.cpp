#include "model/single_scattering/half_space.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <limits>

namespace opaline {
namespace {

using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
using Medium1 = ScatteringMedium<double>;
const double infinity = std::numeric_limits<double>::infinity();

double over_sphere(const std::function<double(double)>& f) { return 2 * pi * Rule::integrate(f, -1.0, 1.0, 15, 1e-12); }

TEST(Phase, FunctionsAreNormalisedWithTheStatedMeanCosine) {
  for (const double g : {-.9, -.3, 0.0, 1e-9, .02, .5, .9}) {
    EXPECT_NEAR(over_sphere([&](double c) { return henyey_greenstein(c, g); }), 1, 1e-10) << g;
    EXPECT_NEAR(over_sphere([&](double c) { return c * henyey_greenstein(c, g); }), g, 1e-10) << g;
    const double k = schlick_k(g);
    EXPECT_NEAR(over_sphere([&](double c) { return schlick_phase(c, k); }), 1, 1e-10) << g;
    EXPECT_NEAR(over_sphere([&](double c) { return c * schlick_phase(c, k); }), schlick_mean_cosine(k), 1e-10) << g;
    EXPECT_NEAR(schlick_mean_cosine(k), g, .08) << g;
  }
  EXPECT_NEAR(henyey_greenstein(.3, 0.0), 1 / (4 * pi), 1e-16);
  EXPECT_GT(henyey_greenstein(1.0, .8), henyey_greenstein(-1.0, .8));
  EXPECT_GT(schlick_phase(1.0, .8), schlick_phase(-1.0, .8));
  EXPECT_NEAR(schlick_mean_cosine(.0300001), schlick_mean_cosine(.0299999), 1e-6);
}

TEST(SingleScattering, TotalsAreTheExactOnes) {
  // Normal beam, isotropic, per transmitted flux: exact totals at alpha 0.9.
  const double rows[][2] = {{1, .138084}, {1.3, .068148}, {1.4, .056936}, {1.5, .048262}};
  for (const auto& row : rows) EXPECT_NEAR(single_scattering_total(Medium1{.1, .9, 0, row[0]}), row[1], 1e-6);
  EXPECT_NEAR(single_scattering_total(Medium1{0, 2, 0, 1}), .5 * (1 - std::log(2.0)), 1e-12);
  // Monte Carlo with the HG phase function at reduced albedo 0.9, eta 1.3 (g, total).
  const double hg[][2] = {{.5, .01797}, {.8, .00522}, {.9, .00237}, {-.3, .13551}};
  for (const auto& row : hg) {
    const double sigma_s = .9 / (1 - row[0]);
    EXPECT_NEAR(single_scattering_total(Medium1{.1, sigma_s, row[0], 1.3}), row[1], .01 * row[1]) << row[0];
  }
}

TEST(SingleScattering, TotalIsTheIntegralOfTheTransmittedIntensity) {
  for (const double eta : {.8, 1.0, 1.2, 1.5}) {
    for (const double g : {-.4, 0.0, .7}) {
      const auto f = [&](double mu) {
        return 2 * pi * henyey_greenstein(-mu, g) * fresnel_transmittance(mu, 1 / eta) * mu / (1 + mu);
      };
      const double critical = eta > 1 ? std::sqrt(1 - 1 / (eta * eta)) : 0;
      const double expected = .6 * Rule::integrate(f, critical, 1.0, 15, 1e-11);
      EXPECT_NEAR(single_scattering_total(Medium1{.4, .6, g, eta}) / expected, 1, 1e-9) << eta << " " << g;
    }
  }
}

TEST(SingleScattering, ProfileEqualsTheIntegralOverDepth) {
  for (const double eta : {.8, 1.0, 1.3}) {
    for (const double r : {1e-3, .05, .7, 4.0}) {
      const double g = .3, sigma_s = 1.6, sigma_t = 2.0;
      const auto f = [&](double t) {
        const double d = std::hypot(r, t), mu = t / d;
        return sigma_s * std::exp(-sigma_t * (t + d)) * henyey_greenstein(-mu, g) * fresnel_transmittance(mu, 1 / eta) *
               mu / (d * d);
      };
      const double start = eta > 1 ? r * std::sqrt(eta * eta - 1) : 0;
      const double expected =
          Rule::integrate(f, start, start + r, 15, 1e-12) + Rule::integrate(f, start + r, infinity, 15, 1e-12);
      EXPECT_NEAR(single_scattering_profile(Medium1{.4, sigma_s, g, eta}, r) / expected, 1, 1e-8) << eta << " " << r;
    }
  }
}

/// Mean of R1 over an annulus.
double annulus_mean(const Medium1& m, double low, double high) {
  const auto ring = [&](double r) { return 2 * pi * r * single_scattering_profile(m, r); };
  return Rule::integrate(ring, low, high, 3, 1e-8) / (pi * (high * high - low * low));
}

TEST(SingleScattering, ProfileIsTheSimulatedOne) {
  struct Row {
    double eta, alpha, low, high, value;
  };
  // Single-scattering column of the Monte Carlo profiles, normal pencil beam, isotropic, sigma_t 1.
  const Row rows[] = {{1, .9, .05, .1, 6.328e-01},  {1, .9, .2, .3, 1.047e-01},   {1, .9, .5, .75, 1.659e-02},
                      {1, .9, 1, 1.5, 2.455e-03},   {1, .5, .02, .05, 9.025e-01}, {1.3, .9, .02, .05, 1.123e+00},
                      {1.3, .9, .1, .2, 1.449e-01}, {1.3, .9, .3, .5, 2.082e-02}, {1.3, .9, .75, 1, 2.100e-03},
                      {1.3, .9, 1, 1.5, 5.308e-04}, {1.3, .5, .2, .3, 3.179e-02}, {1.3, .99, .5, .75, 6.961e-03}};
  for (const Row& row : rows) {
    const Medium1 m{1 - row.alpha, row.alpha, 0, row.eta};
    EXPECT_NEAR(annulus_mean(m, row.low, row.high) / row.value, 1, .01) << row.eta << " " << row.low;
  }
}

TEST(SingleScattering, ProfileIntegratesToTheTotal) {
  for (const double eta : {1.0, 1.4}) {
    const Medium1 m{.3, 1.2, .2, eta};
    double sum = 0;
    for (double y = -18; y < 4; y += .05) {
      const double r = std::exp(y);
      sum += .05 * 2 * pi * r * r * single_scattering_profile(m, r);
    }
    EXPECT_NEAR(sum / single_scattering_total(m), 1, 1e-6);
  }
}

TEST(SingleScattering, CumulativeIsTheIntegralToR) {
  for (const double eta : {.9, 1.0, 1.4}) {
    const Medium1 m{.3, 1.2, .2, eta};
    for (const double r : {1e-4, .02, .5, 3.0}) {
      const double sum =
          Rule::integrate([&](double s) { return 2 * pi * s * single_scattering_profile(m, s); }, 0.0, r, 8, 1e-11);
      EXPECT_NEAR(single_scattering_cumulative(m, r) / sum, 1, 1e-9) << eta << " " << r;
    }
    EXPECT_NEAR(single_scattering_cumulative(m, 1e3) / single_scattering_total(m), 1, 1e-12);
    EXPECT_EQ(single_scattering_cumulative(m, 0.0), 0);
  }
}

TEST(SingleScattering, ScalesWithTheCoefficients) {
  const Medium1 one{.3, 1.2, .2, 1.3}, scaled{3, 12, .2, 1.3};
  EXPECT_NEAR(single_scattering_profile(scaled, .03) / (100 * single_scattering_profile(one, .3)), 1, 1e-12);
}

TEST(HanrahanKrueger, AlbedoAtNormalIncidenceIsTheTotalTimesTheEnteringLight) {
  for (const double eta : {.9, 1.0, 1.4}) {
    const Medium1 m{.2, .8, .3, eta};
    const auto f = [&](double c) {
      if (1 - c * c >= eta * eta) return 0.0;
      const double mu = std::sqrt(1 - (1 - c * c) / (eta * eta));
      return 2 * pi * c * hanrahan_krueger_brdf(m, 1.0, c, -mu, infinity);
    };
    const double low = eta < 1 ? std::sqrt(1 - eta * eta) : 0;
    const double sum = Rule::integrate(f, low, 1.0, 15, 1e-11);
    EXPECT_NEAR(sum, fresnel_transmittance(1.0, eta) * single_scattering_total(m), 1e-8) << eta;
  }
}

TEST(HanrahanKrueger, IsReciprocalAndAddsUpLayers) {
  const Medium1 m{.2, .8, .3, 1.4};
  const auto f = [&](double a, double b, double tau) { return hanrahan_krueger_brdf(m, a, b, -.6, tau); };
  EXPECT_DOUBLE_EQ(f(.3, .8, .7), f(.8, .3, .7));
  EXPECT_EQ(f(.3, .8, 0.0), 0);
  const double mu_a = std::sqrt(1 - (1 - .09) / 1.96), mu_b = std::sqrt(1 - (1 - .64) / 1.96);
  const double seen = std::exp(-.7 * (1 / mu_a + 1 / mu_b));  // the layer below, seen through the upper one
  EXPECT_NEAR(f(.3, .8, infinity), f(.3, .8, .7) + seen * f(.3, .8, infinity), 1e-14);
}

}  // namespace
}  // namespace opaline
