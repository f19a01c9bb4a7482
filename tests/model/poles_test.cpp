#include "model/profiles/poles.h"

#include <gtest/gtest.h>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <cmath>

namespace opaline {
namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;

/// d/z - 1 for the distance that holds a share xi of the pole's flux, by bisection of its logarithm.
Wide excess_by_bisection(const Wide& c, const Wide& xi) {
  Wide low = -1500, high = 100;
  for (int i = 0; i < 90; ++i) {
    const Wide middle = (low + high) / 2, w = exp(middle);
    // 1 - exp(-c w)/(1 + w), in a form that survives tiny w.
    const Wide share = -expm1(Wide(-c * w - boost::multiprecision::log1p(w)));
    (share < xi ? low : high) = middle;
  }
  return exp(low);
}

TEST(PoleSampling, MatchesBisectionInHighPrecision) {
  for (const double c : {0.0, 1e-300, 1e-12, 1e-3, .4, 1.0, 30.0, 1e6, 1e300}) {
    for (const double xi : {1e-300, 1e-17, 1e-6, .1, .5, .9, 1 - 1e-9, 1 - 0x1p-53}) {
      if (xi / (1 + c) < 1e-300) continue;  // d/z - 1 would be subnormal
      const Wide w = excess_by_bisection(c, xi);
      const double expected = Wide(sqrt(Wide(w * (w + 2)))).convert_to<double>();
      EXPECT_NEAR(sample_pole(1.0, c, xi), expected, 1e-14 * expected) << c << " " << xi;
    }
  }
}

TEST(PoleSampling, ScalesWithDepthAndStartsAtZero) {
  EXPECT_EQ(sample_pole(1.0, 2.0, 0.0), 0);
  EXPECT_NEAR(sample_pole(1e-40, 2e40, .3), 1e-40 * sample_pole(1.0, 2.0, .3), 1e-54);
  EXPECT_NEAR(sample_pole(2.0, 0.0, .5), 2 * std::sqrt(3.0), 1e-14);  // d = z/(1 - xi)
}

TEST(PoleSampling, IsTheInverseOfTheCumulative) {
  for (const double sigma : {0.0, .03, 1.0, 20.0}) {
    for (double xi = 1e-4; xi < 1; xi += .0307) {
      const double share = pole_cumulative(sample_pole(.7, sigma, xi), .7, sigma) / std::exp(-.7 * sigma);
      EXPECT_NEAR(share, xi, 3e-15 + 1e-14 * xi) << sigma;
    }
  }
}

TEST(PoleCumulative, KeepsItsDigitsAtSmallRadii) {
  for (const double sigma : {0.0, .2, 50.0}) {
    for (const double r : {1e-150, 1e-20, 1e-8, 1e-3, 1.0, 100.0}) {
      const double z = .3;
      const boost::multiprecision::number<boost::multiprecision::cpp_bin_float<400>> wr = r, wz = z, ws = sigma;
      const auto d = decltype(wr)(sqrt(decltype(wr)(wr * wr + wz * wz)));
      const double expected =
          decltype(wr)(exp(decltype(wr)(-ws * wz)) - wz / d * exp(decltype(wr)(-ws * d))).convert_to<double>();
      EXPECT_NEAR(pole_cumulative(r, z, sigma), expected, 1e-14 * expected) << sigma << " " << r;
    }
  }
}

TEST(PoleCumulative, GrowsByTheFluxOfARing) {
  for (const double sigma : {0.0, .5, 4.0}) {
    for (const double r : {.05, .3, 1.0, 3.0}) {
      const Wide h("1e-15"), wr = r, z = .4, s = sigma;
      const Wide slope = (pole_cumulative(Wide(wr + h), z, s) - pole_cumulative(Wide(wr - h), z, s)) / (2 * h);
      const double ring = 2 * pi * r * pole_evaluate_squared(r * r, .4, sigma * sigma);
      EXPECT_NEAR(Wide(ring / slope).convert_to<double>(), 1, 1e-13);
    }
  }
}

TEST(PoleSampling, TakesFewSteps) {
  // Eight are promised. Measured over 1e7 random inputs: three.
  int total = 0, count = 0;
  for (double c = 0; c < 1e20; c = c * 1.7 + 1e-20)
    for (const double xi : {1e-300, 1e-16, 1e-8, 1e-3, 0.1, 0.5, 0.9, 0.999, 1 - 1e-8, 1 - 0x1p-53}) {
      int steps = 0;
      sample_pole(1, c, xi, &steps);
      EXPECT_GE(steps, 1) << c << " " << xi;
      EXPECT_LE(steps, 4) << c << " " << xi;
      total += steps, ++count;
    }
  EXPECT_LT(total, 2.5 * count);
}

TEST(PolePair, StaysFiniteAtBothEndsAndForOneSidedShares) {
  for (const double sigma : {0.0, 1e-3, 1.0, 1e3, 1e80}) {
    for (const double xi : {0.0, 1e-300, .5, .5 + 1e-16, 1 - 0x1p-53}) {
      const double r = sample_pole_pair(1.0, 4.0, sigma, xi);
      EXPECT_TRUE(std::isfinite(r) && r >= 0) << sigma << " " << xi;
    }
  }
}

TEST(PolePair, ChoosesAPoleByItsShareOfTheFlux) {
  // Below the share the near pole is sampled with the stretched number, above it the far one.
  const double sigma = .25, share = 1 / (1 + std::exp(-sigma * 3.0));
  EXPECT_NEAR(sample_pole_pair(1, 4, sigma, .5 * share), sample_pole(1, sigma, .5), 1e-13);
  EXPECT_NEAR(sample_pole_pair(1, 4, sigma, share + .5 * (1 - share)), sample_pole(4, sigma, .5), 1e-13);
  EXPECT_LT(sample_pole_pair(1, 4, sigma, std::nextafter(share, 1.0)), 1e-6);  // the far pole, from its start
}

}  // namespace
}  // namespace opaline
