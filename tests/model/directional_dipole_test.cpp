#include "model/profiles/directional_dipole.h"

#include "model/profiles/directional_normal_beam.h"
#include "model/profiles/profile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

using Dipole = DirectionalDipole<double>;
using V = Vector3<double>;

Dipole dipole(double alpha_prime, double eta, double g = 0) {
  return Dipole(Medium<double>{1 - alpha_prime, alpha_prime, eta}, g);
}

TEST(DirectionalDipole, NormalBeamTotalsAreTheTabulatedOnes) {
  struct Row {
    double eta, alpha_prime, total;
  };
  const Row rows[] = {{1, .5, .34895},    {1, .8, .55482},     {1, .9, .70942},    {1, .95, .84853},
                      {1, .99, 1.08660},  {1, .999, 1.25240},  {1.3, .5, .22390},  {1.3, .8, .35592},
                      {1.3, .9, .47460},  {1.3, .95, .60156},  {1.3, .99, .87124}, {1.3, .999, 1.10278},
                      {1.5, .5, .16846},  {1.5, .8, .26691},   {1.5, .9, .36012},  {1.5, .95, .46940},
                      {1.5, .99, .74045}, {1.5, .999, 1.01568}};
  for (const Row& row : rows) {
    const Dipole d = dipole(row.alpha_prime, row.eta);
    double sum = 0;
    for (double y = -14; y < 7; y += .02) sum += .02 * 2 * pi * std::exp(2 * y) * d.normal_beam(std::exp(y));
    EXPECT_NEAR(sum, row.total, 1.5e-4 * row.total) << row.eta << " " << row.alpha_prime;
  }
}

TEST(DirectionalDipole, RadialFormIsTheVectorForm) {
  for (const double alpha_prime : {.3, .9, .9999}) {
    for (const double eta : {.8, 1.0, 1.4}) {
      const Medium<double> m{2 * (1 - alpha_prime), 2 * alpha_prime, eta};
      const Dipole vectors(m, .5);
      const DirectionalNormalBeam<double> radial(m);
      for (const double r : {0.0, 1e-3, .1, .5, 2.0, 20.0}) {
        const double expected = vectors.normal_beam(r);
        EXPECT_NEAR(radial.evaluate(r) / expected, 1, 1e-11) << alpha_prime << " " << eta << " " << r;
      }
      EXPECT_NEAR(find_profile("directional_dipole")->make(m)->evaluate(.7) / vectors.normal_beam(.7), 1, 1e-12);
    }
  }
  EXPECT_NEAR(find_profile("directional_dipole")->make({.001, .999, 1})->total(), 1.25240, 2e-4);
}

TEST(DirectionalDipole, IsTheSameFromEverySideOfANormalBeam) {
  const Dipole d = dipole(.9, 1.3);
  const V up = {0, 0, 1}, down = {0, 0, -1};
  const double expected = d.normal_beam(.7) / pi;
  for (double a = 0; a < 6; a += .7) {
    EXPECT_NEAR(d.evaluate({.7 * std::cos(a), .7 * std::sin(a), 0}, down, up, up), expected, 1e-13 * expected);
  }
}

TEST(DirectionalDipole, IsUnchangedByARotationOfEverything) {
  const Dipole d = dipole(.9, 1.3, .4);
  const auto turned = [](const V& v) {
    const double c = std::cos(.8), s = std::sin(.8);
    const V a = {v[0], c * v[1] - s * v[2], s * v[1] + c * v[2]};
    return V{c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]};
  };
  const V x = {.3, -.5, .1}, w = {.48, 0, -.877268488}, n_i = {0, 0, 1}, n_o = {0, .6, .8};
  const double expected = d.evaluate(x, w, n_i, n_o);
  EXPECT_GT(expected, 0);
  EXPECT_NEAR(d.evaluate(turned(x), turned(w), turned(n_i), turned(n_o)), expected, 1e-12 * expected);
}

TEST(DirectionalDipole, ObliqueLightShiftsForward) {
  const Dipole d = dipole(.95, 1.3);
  const V up = {0, 0, 1}, w = {.6, 0, -.8};
  for (const double r : {.5, 1.0, 3.0}) {
    EXPECT_GT(d.evaluate({r, 0, 0}, w, up, up), d.evaluate({-r, 0, 0}, w, up, up)) << r;
  }
}

TEST(DirectionalDipole, ScalesWithTheCoefficients) {
  const Dipole one(Medium<double>{.1, .9, 1.3}, .5), scaled(Medium<double>{1, 9, 1.3}, .5);
  for (const double r : {.1, 1.0, 5.0}) {
    EXPECT_NEAR(scaled.normal_beam(r / 10) / (100 * one.normal_beam(r)), 1, 1e-12) << r;
  }
}

TEST(DirectionalDipole, BackLightUsesTheUnreducedDistance) {
  const V up = {0, 0, 1}, w = {0, 0, -1}, x = {.3, 0, -.2}, n_o = {0, 0, -1};
  EXPECT_GT(std::abs(dipole(.9, 1.3, .8).evaluate(x, w, up, n_o) - dipole(.9, 1.3, 0).evaluate(x, w, up, n_o)), 1e-3);
  EXPECT_EQ(dipole(.9, 1.3, .8).normal_beam(.3), dipole(.9, 1.3, 0).normal_beam(.3));
}

TEST(DirectionalDipole, StaysFiniteAtTheEntry) {
  const Dipole d = dipole(.9, 1.3);
  EXPECT_TRUE(std::isfinite(d.normal_beam(0)) && d.normal_beam(0) >= 0);
}

}  // namespace
}  // namespace opaline
