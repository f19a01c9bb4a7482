#include "model/profiles/multipole.h"

#include "model/profiles/standard_dipole.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

using Jet1 = ceres::Jet<double, 1>;

const std::vector<Slab<double>> slabs = {{{.1, .9, 1.3}, 2, 1.3},
                                         {{.01, 2, 1.4}, 5, 1.0},
                                         {{0, 1, 1.3}, 3, 1.5},
                                         {{.5, .5, 1.0}, 1.5, 1},
                                         {{0, 3, 1.0}, .6, 1.0}};

/// The plain sum of many images, by hand.
double brute_force(const Slab<double>& slab, double r, bool transmitted) {
  const double st = slab.medium.sigma_a + slab.medium.sigma_s_prime, s = std::sqrt(3 * slab.medium.sigma_a * st);
  const double ell = 1 / st, zb0 = 2 * ell / 3 * dipole_boundary_a(slab.medium.eta);
  const double d = slab.thickness, zbd = 2 * ell / 3 * dipole_boundary_a(slab.eta_below), period = d + zb0 + zbd;
  const auto pole = [&](double z) {
    const double distance = std::hypot(r, z);
    return z * (1 + s * distance) * std::exp(-s * distance) / std::pow(distance, 3);
  };
  double sum = 0;
  for (int i = 20000; i >= -20000; --i) {
    const double zr = 2 * i * period + ell, zv = 2 * i * period - ell - 2 * zb0;
    sum += transmitted ? pole(d - zr) - pole(d - zv) : pole(zr) - pole(zv);
  }
  return slab.medium.sigma_s_prime / st / (4 * pi) * sum;
}

TEST(Multipole, EqualsTheSumOfManyImages) {
  for (const auto& slab : slabs) {
    const Multipole<double> m(slab);
    for (const double x : {0.0, .1, .3, .499, .501, .8, 1.5}) {
      const double r = x * m.slab.period, scale = 1e-9 / (m.slab.period * m.slab.period);
      const double reflected = brute_force(slab, r, false), transmitted = brute_force(slab, r, true);
      EXPECT_NEAR(m.reflectance(r), reflected, 1e-8 * reflected + scale) << slab.thickness << " " << x;
      EXPECT_NEAR(m.transmittance(r), transmitted, 1e-8 * transmitted + scale) << slab.thickness << " " << x;
    }
  }
}

TEST(Multipole, ImagesAndModesMeet) {
  for (const auto& slab : slabs) {
    const Multipole<double> m(slab);
    const double below = .5 * m.slab.period * (1 - 1e-13), above = .5 * m.slab.period;
    EXPECT_NEAR(m.reflectance(below) / m.reflectance(above), 1, 1e-8) << slab.thickness;
    EXPECT_NEAR(m.transmittance(below) / m.transmittance(above), 1, 1e-8) << slab.thickness;
  }
}

TEST(Multipole, TotalsAreTheIntegrals) {
  for (const auto& slab : slabs) {
    const Multipole<double> m(slab);
    double reflected = 0, transmitted = 0;
    for (double y = -16; y < 5.5; y += .05) {
      const double r = m.slab.depth * std::exp(y), ring = .05 * 2 * pi * r * r;
      reflected += ring * m.reflectance(r);
      transmitted += ring * m.transmittance(r);
    }
    EXPECT_NEAR(reflected / m.total_reflectance(), 1, 1e-7) << slab.thickness;
    EXPECT_NEAR(transmitted / m.total_transmittance(), 1, 1e-7) << slab.thickness;
  }
}

TEST(Multipole, ThickSlabsAreTheStandardDipole) {
  for (const Medium<double>& medium : {Medium<double>{.1, .9, 1.3}, {.7, .3, 1.0}}) {
    const Multipole<double> m({medium, 200, 1.4});
    const StandardDipole<double> dipole(medium);
    EXPECT_NEAR(m.total_reflectance() / dipole.total(), 1, 1e-9);
    EXPECT_LT(m.total_transmittance(), 1e-20);
    for (const double r : {0.0, .1, 1.0, 8.0}) EXPECT_NEAR(m.reflectance(r) / dipole.evaluate(r), 1, 1e-9) << r;
  }
}

TEST(Multipole, WithoutAbsorptionAllLightLeaves) {
  for (const double thickness : {1.5, 4.0, 1e3}) {
    const Multipole<double> m({{0, 1, 1.3}, thickness, 1.5});
    EXPECT_NEAR(m.total_reflectance() + m.total_transmittance(), 1, 1e-14);
  }
}

TEST(Multipole, ThinSlabsScatterOnceOnTheAverage) {
  // alpha' d/(2 l) to either side, and no jump where the source is moved or the beam passes.
  const auto total = [](double d) {
    const Multipole<double> m({{.2, .8, 1.3}, d, 1.3});
    return std::pair(m.total_reflectance(), m.total_transmittance());
  };
  for (const double d : {1e-6, 1e-3}) {
    EXPECT_NEAR(total(d).first / (.4 * d), 1, 5 * d);
    EXPECT_NEAR(total(d).second / (.4 * d), 1, 5 * d);
  }
  for (const double d : {1.0, 1.5}) {
    EXPECT_NEAR(total(d * (1 - 1e-9)).first, total(d * (1 + 1e-9)).first, 1e-8) << d;
    EXPECT_NEAR(total(d * (1 - 1e-9)).second, total(d * (1 + 1e-9)).second, 1e-8) << d;
  }
  const SlabSource<double> thin({{.2, .8, 1.3}, .25, 1.3});
  EXPECT_DOUBLE_EQ(thin.strength + thin.unscattered, 1);
  EXPECT_DOUBLE_EQ(thin.depth + thin.below, .25);
}

TEST(Multipole, TwiceTheSourceDepthSplitsEvenly) {
  const Multipole<double> m({{.1, .9, 1.3}, 2, 1.3});
  EXPECT_NEAR(m.total_reflectance(), .285, 1e-3);
  EXPECT_NEAR(m.total_transmittance(), m.total_reflectance(), 1e-14);
  for (const double r : {0.0, .7, 3.0, 9.0}) EXPECT_NEAR(m.transmittance(r) / m.reflectance(r), 1, 1e-8);
}

TEST(Multipole, FallsLikeItsSlowestModeFarAway) {
  const Multipole<double> m({{.1, .9, 1.3}, 2, 1.3});
  const double beta = std::sqrt(m.slab.sigma_tr_squared + std::pow(pi / m.slab.period, 2)), r = 40 * m.slab.period;
  const double expected = std::exp(-beta * m.slab.period) * std::sqrt(r / (r + m.slab.period));
  EXPECT_NEAR(m.reflectance(r + m.slab.period) / m.reflectance(r) / expected, 1, 1e-4);
}

TEST(Multipole, BesselFunctionIsTheLibrarys) {
  for (const double x : {1.0, 3.0, 20.0, 300.0}) {
    EXPECT_NEAR(bessel_k0(x) / std::cyl_bessel_k(0.0, x), 1, 1e-13) << x;
  }
}

TEST(Multipole, DualNumbersGiveTheDerivative) {
  for (const double a : {0.0, .1}) {
    const auto slab = [&](const auto& s) {
      using T = std::decay_t<decltype(s)>;
      return Slab<T>{{T(a), s, T(1.3)}, T(3.0), T(1.3)};
    };
    for (const double r : {.1, 1.0, 6.0}) {
      const double h = 1e-5;
      const auto at = [&](double s) { return Multipole<double>(slab(s)).reflectance(r); };
      const double expected = (at(1 + h) - at(1 - h)) / (2 * h);
      const double jet = Multipole<Jet1>(slab(Jet1(1.0, 0))).reflectance(Jet1(r)).v[0];
      EXPECT_NEAR(jet, expected, 1e-6 * std::abs(expected)) << a << " " << r;
    }
  }
}

}  // namespace
}  // namespace opaline
