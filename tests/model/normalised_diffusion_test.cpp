#include "model/profiles/normalised_diffusion.h"

#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>

#include <cmath>

namespace opaline {
namespace {

using Searchlight = SearchlightNormalisedDiffusion<double>;
using Diffuse = DiffuseNormalisedDiffusion<double>;
using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;

Medium<double> medium(double alpha, double eta) { return {1 - alpha, alpha, eta}; }

TEST(NormalisedDiffusion, AlbedoIsTheExactOneWithinItsStatedError) {
  struct Row {
    double eta, alpha, exact, tolerance;
  };
  // Exact totals of isotropic half spaces for a normal beam, per transmitted flux.
  const Row rows[] = {{1, .5, .115226, .01},     {1, .9, .414947, .005},    {1, .99, .752721, .005},
                      {1, .9999, .971418, .005}, {1.3, .8, .181324, .04},   {1.3, .9, .290729, .02},
                      {1.3, .99, .656564, .02},  {1.3, .999, .871583, .02}, {1.5, .9, .229082, .025},
                      {1.5, .99, .585397, .02}};
  for (const Row& row : rows) {
    EXPECT_NEAR(Searchlight(medium(row.alpha, row.eta)).total() / row.exact, 1, row.tolerance)
        << row.eta << " " << row.alpha;
  }
  EXPECT_NEAR(Diffuse(medium(.9, 1)).total(), .478024, .0022);
  EXPECT_NEAR(Diffuse(medium(.3, 1)).total(), .074451, .0022);
  EXPECT_EQ(Searchlight(medium(1, 1.4)).total(), 1);
  EXPECT_EQ(Diffuse(medium(1, 1.4)).total(), 1);
}

TEST(NormalisedDiffusion, IsThePublishedProfileOutsideItsCore) {
  for (const double alpha : {.3, .9, .999}) {
    const double u = std::sqrt(1 - alpha);
    const double a = (1 - u) * (1 - .128 * u) / (1 + 1.83 * u), s = 1.85 - a + 7 * std::pow(std::abs(a - .8), 3);
    const Searchlight p(medium(alpha, 1));
    EXPECT_NEAR(p.d * s, 1, 1e-14);
    for (const double x : {.1, .3, 1.0, 4.0, 20.0}) {
      const double r = x * p.d;
      const double published = a * s / (8 * pi * r) * (std::exp(-s * r) + std::exp(-s * r / 3));
      const double deviation = .5 * p.core_share * p.core_share / (x * x);
      EXPECT_NEAR(p.evaluate(r) / published, 1, 1.2 * deviation * (1 + x)) << x;
    }
  }
}

TEST(NormalisedDiffusion, DiffuseShapeIsThePublishedOne) {
  for (const double alpha : {.3, .9, .999}) {
    const double u = std::sqrt(1 - alpha), a = (1 - u) * (1 - .139 * u) / (1 + 1.17 * u);
    EXPECT_NEAR(Diffuse(medium(alpha, 1)).d * (1.9 - a + 3.5 * (a - .8) * (a - .8)), 1, 1e-14);
    EXPECT_NEAR(Diffuse(medium(alpha, 1)).total(), a, 1e-15);
    EXPECT_EQ(Diffuse(medium(alpha, 1.5)).d, Diffuse(medium(alpha, 1)).d);
  }
}

TEST(NormalisedDiffusion, ProfileFollowsTransportAtMatchedIndices) {
  // Shares of the flux in annuli, Monte Carlo of a normal beam, eta 1, alpha 0.9, isotropic.
  const Searchlight p(medium(.9, 1));
  struct Row {
    double low, high, radiance;
  };
  const Row rows[] = {{.05, .1, 7.8528e-01}, {.2, .3, 1.7909e-01}, {.5, .75, 4.7566e-02},
                      {1, 1.5, 1.3973e-02},  {2, 3, 2.8386e-03},   {4, 5, 4.1058e-04}};
  for (const Row& row : rows) {
    const double flux = row.radiance * pi * (row.high * row.high - row.low * row.low);
    EXPECT_NEAR((p.cumulative(row.high) - p.cumulative(row.low)) / flux, 1, .1) << row.low;
  }
}

TEST(NormalisedDiffusion, CumulativeIsTheIntegral) {
  for (const double alpha : {.2, .95, 1.0}) {
    const Diffuse p(medium(alpha, 1.3));
    for (const double r : {.1 * p.c, p.c, 10 * p.c, p.d, 9 * p.d}) {
      const double sum = Rule::integrate([&](double x) { return 2 * pi * x * p.evaluate(x); }, 0.0, r, 14, 1e-13);
      EXPECT_NEAR(p.cumulative(r) / sum, 1, 1e-11) << r;
    }
    EXPECT_NEAR(p.cumulative(1e4 * p.d), p.total(), 1e-15);
  }
}

TEST(NormalisedDiffusion, MomentsAreThePublishedOnes) {
  const Searchlight p(medium(.9, 1.2));
  const auto moment = [&](int k) {
    return Rule::integrate([&](double x) { return 2 * pi * x * p.evaluate(x) * std::pow(x, k); }, 0.0, 200 * p.d, 14,
                           1e-12) /
           p.total();
  };
  EXPECT_NEAR(moment(1), 2.5 * p.d, 1e-3 * p.d);
  EXPECT_NEAR(moment(2), 14 * p.d * p.d, 1e-3 * p.d * p.d);
}

TEST(NormalisedDiffusion, SamplingInvertsEachPart) {
  const Searchlight p(medium(.9, 1.3));
  const double share = Searchlight::core_flux();
  // Golubev's form of the same root.
  for (const double xi : {.02, .3, .9, .9999}) {
    const double u = 1 - xi, g = 1 + 4 * u * (2 * u + std::sqrt(1 + 4 * u * u));
    const double rho = 3 * p.d * std::log((1 + std::cbrt(1 / g) + std::cbrt(g)) / (4 * u));
    EXPECT_NEAR(p.sample(xi), std::sqrt(rho * rho - p.c * p.c), 1e-12 * p.d);
    EXPECT_NEAR(Searchlight::beyond(rho / p.d), u, 1e-14);
  }
  EXPECT_NEAR(p.sample(.5 * share), p.c * std::sqrt(std::log(2.0) * (std::log(2.0) + 2)), 1e-14);
  EXPECT_TRUE(std::isfinite(p.sample(1 - 0x1p-53)));
}

}  // namespace
}  // namespace opaline
