#include "model/profiles/better_dipole.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <array>
#include <limits>
#include <vector>

namespace opaline {
namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Jet3 = ceres::Jet<double, 3>;
using Dipole = BetterDipole<double>;
using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;

const std::vector<Medium<double>> media = {{.0024, 3.21, 1.3}, {.48, 1.01, 1.4}, {1.45, .03, 1.3},
                                           {1e-6, 20, 1.5},    {.3, .7, 1.0},    {.1, .9, .8}};

Medium<Wide> wide(const Medium<double>& m) { return {Wide(m.sigma_a), Wide(m.sigma_s_prime), Wide(m.eta)}; }

TEST(BetterDipole, EqualsThePrintedFormula) {
  for (const auto& m : media) {
    const double st = m.sigma_a + m.sigma_s_prime, alpha = m.sigma_s_prime / st;
    const double diffusion = (2 * m.sigma_a + m.sigma_s_prime) / (3 * st * st), s = std::sqrt(m.sigma_a / diffusion);
    const double c1 = diffuse_reflectance_internal(m.eta), c2 = second_moment_internal(m.eta);
    const double c_phi = (1 - c1) / 4, c_e = (1 - c2) / 2, a = (1 + c2) / (1 - c1);
    const double zr = 1 / st, zv = zr + 4 * a * diffusion;
    for (const double r : {0.0, .01, .3, 1.0, 4.0}) {
      const double dr = std::hypot(r, zr), dv = std::hypot(r, zv), er = std::exp(-s * dr), ev = std::exp(-s * dv);
      const double flux = zr * (1 + s * dr) * er / std::pow(dr, 3) + zv * (1 + s * dv) * ev / std::pow(dv, 3);
      const double expected = alpha * alpha / (4 * pi) * (c_e * flux + c_phi / diffusion * (er / dr - ev / dv));
      EXPECT_NEAR(Dipole(m).evaluate(r), expected, 1e-12 * expected) << m.sigma_a << " " << r;
    }
  }
}

TEST(BetterDipole, TotalsAreThePublishedOnes) {
  struct Row {
    double eta, alpha_prime, total;
  };
  const Row rows[] = {{1, .5, .04598},    {1, .8, .19881},    {1, .9, .34381},    {1, .95, .48581},
                      {1, .99, .73785},   {1, .999, .91134},  {1.3, .5, .02889},  {1.3, .8, .13110},
                      {1.3, .9, .24329},  {1.3, .95, .37010}, {1.3, .99, .64194}, {1.3, .999, .86920},
                      {1.5, .5, .02160},  {1.5, .8, .09831},  {1.5, .9, .18707},  {1.5, .95, .29624},
                      {1.5, .99, .56634}, {1.5, .999, .83127}};
  for (const Row& row : rows) {
    const Dipole dipole(Medium<double>{1 - row.alpha_prime, row.alpha_prime, row.eta});
    EXPECT_NEAR(dipole.total(), row.total, 6e-6) << row.eta << " " << row.alpha_prime;
  }
}

TEST(BetterDipole, CumulativeIsTheIntegralToR) {
  for (const auto& m : media) {
    const Dipole d(m);
    for (const double r : {.01 * d.z_r, .3 * d.z_r, d.z_r, .99 * d.z_v, 1.01 * d.z_v, 6 * d.z_v}) {
      const double sum = Rule::integrate([&](double x) { return 2 * pi * x * d.evaluate(x); }, 0.0, r, 12, 1e-13);
      EXPECT_NEAR(sum / d.cumulative(r), 1, 1e-12) << m.sigma_a << " " << r;
    }
    EXPECT_NEAR(d.cumulative(1e12 * d.z_v) / d.total(), 1, 1e-11);
  }
}

TEST(BetterDipole, DoubleIsWithinRoundingOfFiftyDigits) {
  for (const auto& m : media) {
    const Dipole dipole(m);
    const BetterDipole<Wide> reference(wide(m));
    for (const double r : {1e-6, .1, 1.0, 4.0, 30.0}) {
      EXPECT_NEAR(Wide(dipole.evaluate(r) / reference.evaluate(Wide(r))).convert_to<double>(), 1, 4e-14);
      EXPECT_NEAR(Wide(dipole.cumulative(r) / reference.cumulative(Wide(r))).convert_to<double>(), 1, 1e-13);
    }
  }
}

TEST(BetterDipole, WithoutAbsorptionEverythingComesBack) {
  for (const double eta : {.7, 1.0, 1.3, 2.0}) {
    const Dipole d(Medium<double>{0, 1.7, eta});
    EXPECT_EQ(d.sigma_tr, 0);
    EXPECT_NEAR(d.total(), 1, 2e-16);
    EXPECT_LE(d.total(), 1);
    EXPECT_NEAR(d.cumulative(1e9), 1, 1e-8);
  }
}

TEST(BetterDipole, SampleInvertsTheCumulative) {
  for (const auto& m : media) {
    const Dipole d(m);
    for (const double xi : {1e-12, 1e-5, .03, .2, .5, .77, .999}) {
      EXPECT_NEAR(d.cumulative(d.sample(xi)) / d.total(), xi, 4e-14 * xi + 1e-15) << m.sigma_a << " " << xi;
    }
    EXPECT_EQ(d.sample(0), 0);
    EXPECT_TRUE(std::isfinite(d.sample(1 - 0x1p-53)));
  }
  EXPECT_TRUE(std::isfinite(Dipole(Medium<double>{0, 2, 1.3}).sample(1 - 0x1p-53)));
  EXPECT_EQ(Dipole(Medium<double>{.5, 0, 1.3}).sample(.7), 0);
}

TEST(BetterDipole, DualNumbersGiveTheGradientDownToNoAbsorption) {
  const Wide h("1e-20");
  for (const double sigma_a : {.7, .01, 1e-9, 0.0}) {
    const Medium<double> m{sigma_a, 2, 1.3};
    const BetterDipole<Jet3> dipole(Medium<Jet3>{Jet3(m.sigma_a, 0), Jet3(m.sigma_s_prime, 1), Jet3(m.eta, 2)});
    const Medium<Wide> w = wide(m);
    const auto at = [](const Medium<Wide>& medium, double r) { return BetterDipole<Wide>(medium).evaluate(Wide(r)); };
    for (const double r : {0.0, .1, 1.0, 5.0}) {
      const Jet3 value = dipole.evaluate(Jet3(r));
      const Wide step = sigma_a > 0 ? h : Wide("1e-33");  // one-sided at 0, where sqrt(sigma_a) bends
      const Wide low = sigma_a > 0 ? Wide(w.sigma_a - h) : Wide(0);
      const std::array<Wide, 3> expected = {
          (at({w.sigma_a + step, w.sigma_s_prime, w.eta}, r) - at({low, w.sigma_s_prime, w.eta}, r)) /
              (w.sigma_a + step - low),
          (at({w.sigma_a, w.sigma_s_prime + h, w.eta}, r) - at({w.sigma_a, w.sigma_s_prime - h, w.eta}, r)) / (2 * h),
          (at({w.sigma_a, w.sigma_s_prime, w.eta + h}, r) - at({w.sigma_a, w.sigma_s_prime, w.eta - h}, r)) / (2 * h)};
      EXPECT_NEAR(value.a, Dipole(m).evaluate(r), 2e-15 * value.a);
      for (int k = 0; k < 3; ++k) {
        const double e = expected[static_cast<std::size_t>(k)].convert_to<double>();
        EXPECT_NEAR(value.v[k], e, 1e-12 * (std::abs(e) + value.a)) << sigma_a << " " << r << " " << k;
      }
    }
  }
}

TEST(BetterDipole, ExtremeInputsStayFinite) {
  for (const double scale : {1e-70, 1e-30, 1.0, 1e30, 1e70}) {
    for (const double alpha : {0.0, 1e-12, .5, 1.0}) {
      const Medium<double> m{scale * (1 - alpha), scale * alpha, 1.3};
      const Dipole d(m);
      for (const double r : {0.0, 1e-150, 1e-9, 1.0, 1e9, 1e150}) {
        EXPECT_TRUE(d.evaluate(r) >= 0 && std::isfinite(d.evaluate(r))) << scale << " " << r;
        EXPECT_TRUE(d.cumulative(r) >= 0 && d.cumulative(r) <= d.total() * (1 + 1e-14)) << scale << " " << r;
      }
    }
  }
}

}  // namespace
}  // namespace opaline
