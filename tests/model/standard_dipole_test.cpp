#include "model/profiles/standard_dipole.h"

#include "model/materials/library.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <functional>
#include <limits>
#include <vector>

namespace opaline {
namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Jet3 = ceres::Jet<double, 3>;
using Dipole = StandardDipole<double>;

const std::vector<Medium<double>> media = {{.0024, 3.21, 1.3}, {.48, 1.01, 1.4}, {1.45, .03, 1.3},
                                           {1e-6, 20, 1.5},    {.3, .7, 1.0},    {.1, .9, .8}};

Medium<Wide> wide(const Medium<double>& m) { return {Wide(m.sigma_a), Wide(m.sigma_s_prime), Wide(m.eta)}; }

/// Adaptive quadrature over (0, inf) in units of `length`.
double integral(const std::function<double(double)>& f, double length) {
  using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
  const auto scaled = [&](double x) { return length * f(length * x); };
  return Rule::integrate(scaled, 0.0, 1.0, 12, 1e-13) +
         Rule::integrate(scaled, 1.0, std::numeric_limits<double>::infinity(), 15, 1e-13);
}

TEST(StandardDipole, EqualsThePrintedFormula) {
  for (const auto& m : media) {
    const double st = m.sigma_a + m.sigma_s_prime, s = std::sqrt(3 * m.sigma_a * st), diffusion = 1 / (3 * st);
    const double fdr = diffuse_reflectance_internal(m.eta), a = (1 + fdr) / (1 - fdr);
    const double zr = 1 / st, zv = zr + 4 * a * diffusion;
    for (const double r : {0.0, .01, .3, 1.0, 7.0}) {
      const double dr = std::hypot(r, zr), dv = std::hypot(r, zv);
      const double expected = m.sigma_s_prime / st / (4 * pi) *
                              (zr * (1 + s * dr) * std::exp(-s * dr) / std::pow(dr, 3) +
                               zv * (1 + s * dv) * std::exp(-s * dv) / std::pow(dv, 3));
      EXPECT_NEAR(Dipole(m).evaluate(r), expected, 1e-13 * expected);
      EXPECT_NEAR(Dipole(m).evaluate_squared(r * r), expected, 1e-13 * expected);
    }
  }
}

TEST(StandardDipole, TotalIsTheIntegralOfTheProfile) {
  for (const auto& m : media) {
    const Dipole dipole(m);
    const double sum = integral([&](double r) { return 2 * pi * r * dipole.evaluate(r); }, dipole.z_r);
    EXPECT_NEAR(sum / dipole.total(), 1, 1e-11);
  }
}

TEST(StandardDipole, SecondMomentIsTheClosedForm) {
  for (const auto& m : media) {
    const Dipole d(m);
    const double sum = integral([&](double r) { return 2 * pi * r * r * r * d.evaluate(r); }, d.z_v);
    const double near = std::exp(-d.sigma_tr * d.z_r), far = std::exp(-d.sigma_tr * d.z_v);
    EXPECT_NEAR(sum / d.total() / (2 / d.sigma_tr * (d.z_r * near + d.z_v * far) / (near + far)), 1, 1e-9);
  }
}

TEST(StandardDipole, CumulativeIsTheIntegralToR) {
  for (const auto& m : media) {
    const Dipole d(m);
    for (const double r : {.1 * d.z_r, d.z_r, 5 * d.z_v}) {
      using Rule = boost::math::quadrature::gauss_kronrod<double, 31>;
      const double sum = Rule::integrate([&](double x) { return 2 * pi * x * d.evaluate(x); }, 0.0, r, 12, 1e-13);
      EXPECT_NEAR(sum / d.cumulative(r), 1, 1e-12);
    }
  }
}

TEST(StandardDipole, DerivativeOfTheCumulativeIsTheRing) {
  const Wide h("1e-15");
  for (const auto& m : media) {
    const StandardDipole<Wide> d(wide(m));
    for (const Wide& r : {Wide("0.02"), Wide(1), Wide(6)}) {
      const Wide slope = (d.cumulative(Wide(r + h)) - d.cumulative(Wide(r - h))) / (2 * h);
      EXPECT_NEAR(Wide(slope / (2 * pi * r * d.evaluate(r))).convert_to<double>(), 1, 1e-15);  // pi is a double
    }
  }
}

TEST(StandardDipole, TotalsAreThePublishedOnes) {
  struct Row {
    double eta, alpha_prime, total;
  };
  const Row rows[] = {{1, .5, .08781},    {1, .8, .24999},    {1, .9, .38558},    {1, .95, .51488},
                      {1, .99, .74671},   {1, .999, .91245},  {1.3, .5, .07451},  {1.3, .8, .19693},
                      {1.3, .9, .29919},  {1.3, .95, .40668}, {1.3, .99, .64463}, {1.3, .999, .86397},
                      {1.5, .5, .07357},  {1.5, .8, .18746},  {1.5, .9, .27471},  {1.5, .95, .36431},
                      {1.5, .99, .58329}, {1.5, .999, .82713}};
  for (const Row& row : rows) {
    const Dipole dipole(Medium<double>{1 - row.alpha_prime, row.alpha_prime, row.eta});
    EXPECT_NEAR(dipole.total(), row.total, 6e-6) << row.eta << " " << row.alpha_prime;
  }
}

TEST(StandardDipole, ScalesWithTheCoefficients) {
  for (const auto& m : media) {
    for (const double k : {1e-3, 7.0}) {
      const Dipole one(m), scaled(Medium<double>{k * m.sigma_a, k * m.sigma_s_prime, m.eta});
      EXPECT_NEAR(scaled.evaluate(.4) / (k * k * one.evaluate(.4 * k)), 1, 1e-13);
      EXPECT_NEAR(scaled.total() / one.total(), 1, 1e-13);
    }
  }
}

/// Gradient of R_d by differences of 50-digit evaluations; one-sided at sigma_a = 0 and at eta = 1.
std::array<double, 3> wide_gradient(const Medium<double>& m, double r) {
  const Wide h("1e-22");
  const auto at = [&](const Wide& a, const Wide& s, const Wide& e) {
    return StandardDipole<Wide>(Medium<Wide>{a, s, e}).evaluate(Wide(r));
  };
  const Wide a = m.sigma_a, s = m.sigma_s_prime, e = m.eta;
  const Wide a_low = m.sigma_a < 1e-20 ? a : Wide(a - h), e_low = m.eta == 1 ? e : Wide(e - h);
  const Wide a_step = m.sigma_a < 1e-20 ? Wide("1e-33") : h;
  const auto slope = [](const Wide& high, const Wide& low, const Wide& step) {
    return Wide((high - low) / step).convert_to<double>();
  };
  return {slope(at(a + a_step, s, e), at(a_low, s, e), Wide(a + a_step - a_low)),
          slope(at(a, s + h, e), at(a, s - h, e), Wide(2 * h)),
          slope(at(a, s, e + h), at(a, s, e_low), Wide(e + h - e_low))};
}

TEST(StandardDipole, DualNumbersGiveTheGradientDownToNoAbsorption) {
  std::vector<Medium<double>> all = media;
  all.insert(all.end(), {{1e-9, 2, 1.3}, {1e-300, 2, 1.3}, {0, 2, 1.3}, {0, 11.6, 1.0}});
  for (const auto& m : all) {
    const StandardDipole<Jet3> dipole(Medium<Jet3>{Jet3(m.sigma_a, 0), Jet3(m.sigma_s_prime, 1), Jet3(m.eta, 2)});
    for (const double r : {0.0, .1, 1.0, 5.0}) {
      const Jet3 value = dipole.evaluate(Jet3(r));
      const auto expected = wide_gradient(m, r);
      EXPECT_NEAR(value.a, Dipole(m).evaluate(r), 1e-15 * value.a);
      const double scale[] = {value.a / (m.sigma_a + m.sigma_s_prime), value.a / m.sigma_s_prime, value.a};
      for (int k = 0; k < 3; ++k) {
        const double tolerance = 1e-13 * (std::abs(expected[static_cast<std::size_t>(k)]) + scale[k]);
        EXPECT_NEAR(value.v[k], expected[static_cast<std::size_t>(k)], tolerance) << m.sigma_a << " " << r << " " << k;
      }
    }
  }
}

TEST(StandardDipole, DoubleIsWithinRoundingOfFiftyDigits) {
  for (const auto& m : media) {
    const Dipole dipole(m);
    const StandardDipole<Wide> reference(wide(m));
    for (const double r : {1e-6, .1, 1.0, 4.0}) {
      EXPECT_NEAR(Wide(dipole.evaluate(r) / reference.evaluate(Wide(r))).convert_to<double>(), 1, 2e-14);
      EXPECT_NEAR(Wide(dipole.cumulative(r) / reference.cumulative(Wide(r))).convert_to<double>(), 1, 1e-14);
    }
  }
}

TEST(StandardDipole, WithoutAbsorptionEverythingIsExact) {
  const MaterialRow* spectralon = find_material("spectralon");
  ASSERT_NE(spectralon, nullptr);
  const Dipole d(Medium<double>{spectralon->sigma_a[0], spectralon->sigma_s_prime[0], spectralon->eta});
  EXPECT_EQ(d.sigma_tr, 0);
  EXPECT_EQ(d.total(), 1);
  for (const double r : {.01, .1, 3.0}) {
    const double expected = 1 - .5 * (d.z_r / std::hypot(r, d.z_r) + d.z_v / std::hypot(r, d.z_v));
    EXPECT_NEAR(d.cumulative(r), expected, 2e-16 + 1e-12 * expected);
  }
  const double far = 1e6;
  EXPECT_NEAR(d.evaluate(far) * far * far * far, (d.z_r + d.z_v) / (4 * pi), 1e-10);
  const StandardDipole<Jet3> jet(Medium<Jet3>{Jet3(0, 0), Jet3(11.6, 1), Jet3(1.3, 2)});
  for (int k = 0; k < 3; ++k) EXPECT_TRUE(std::isfinite(jet.total().v[k]));
}

TEST(StandardDipole, WithoutScatteringNothingComesBack) {
  const Dipole d(Medium<double>{.5, 0, 1.3});
  EXPECT_EQ(d.evaluate(.1), 0);
  EXPECT_EQ(d.total(), 0);
  EXPECT_EQ(d.cumulative(3), 0);
  EXPECT_TRUE(std::isfinite(d.sample(.7)));
}

TEST(StandardDipole, ExtremeInputsStayFinite) {
  for (const double scale : {1e-90, 1e-30, 1.0, 1e30, 9e89}) {
    for (const double alpha : {1e-12, .5, 1.0}) {
      const Medium<double> m{scale * (1 - alpha), scale * alpha, 1.3};
      const Dipole d(m);
      const StandardDipole<Jet3> jet(Medium<Jet3>{Jet3(m.sigma_a, 0), Jet3(m.sigma_s_prime, 1), Jet3(m.eta, 2)});
      for (const double r : {0.0, 1e-150, 1e-9, 1.0, 1e9, 1e150}) {
        EXPECT_TRUE(d.evaluate(r) >= 0 && std::isfinite(d.evaluate(r))) << scale << " " << r;
        EXPECT_TRUE(d.cumulative(r) >= 0 && d.cumulative(r) <= d.total() * (1 + 1e-15)) << scale << " " << r;
        if (r <= 1e9) {
          EXPECT_TRUE(std::isfinite(jet.evaluate(Jet3(r)).v.sum())) << scale << " " << alpha << " " << r;
        }
      }
    }
  }
}

}  // namespace
}  // namespace opaline
