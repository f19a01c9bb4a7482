#include "model/fresnel.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <array>
#include <limits>

namespace opaline {
namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Wider = boost::multiprecision::cpp_bin_float_100;
using Jet1 = ceres::Jet<double, 1>;
using Jet2 = ceres::Jet<double, 2>;

/// Distance in units of the last place of the reference.
double ulps(double value, const Wider& reference) {
  const double nearest = std::abs(reference.convert_to<double>());
  const double ulp = std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest;
  return Wider(abs(Wider(value) - reference) / ulp).convert_to<double>();
}

/// The equations as a textbook prints them, with Snell's law; for high precision.
Wide textbook_reflectance(const Wide& c, const Wide& eta) {
  const Wide sin2_t = (1 - c * c) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const Wide t = sqrt(Wide(1 - sin2_t));
  const Wide r_s = (c - eta * t) / (c + eta * t), r_p = (eta * c - t) / (eta * c + t);
  return (r_s * r_s + r_p * r_p) / 2;
}

/// 2 int F c dc by quadrature of the textbook form, split at the critical angle.
Wide mean_by_quadrature(const Wide& eta) {
  static boost::math::quadrature::tanh_sinh<Wide> rule;
  const Wide critical = eta < 1 ? Wide(sqrt(Wide(1 - eta * eta))) : Wide(0);
  const auto integrand = [&](const Wide& c) { return Wide(2 * c * textbook_reflectance(c, eta)); };
  return critical * critical + rule.integrate(integrand, critical, Wide(1), Wide("1e-30"));
}

/// Dunkle 1963: the mean reflectance from the thin side, n > 1.
Wider dunkle(const Wider& n) {
  const Wider n2 = n * n, n4 = n2 * n2;
  return Wider(1) / 2 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) -
         2 * n * n2 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
         8 * n4 * (n4 + 1) * log(n) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) +
         n2 * (n2 - 1) * (n2 - 1) * log(Wider((n - 1) / (n + 1))) / ((n2 + 1) * (n2 + 1) * (n2 + 1));
}

TEST(FresnelReflectance, AgreesWithPublishedSpotValues) {
  const std::array<double, 6> angles = {0, .2, .5, 1, 1.2, 1.5};
  struct Row {
    double eta;
    std::array<double, 6> values;
  };
  const Row rows[] = {{.5, {.11111111, .11175198, .28326783, 1, 1, 1}},
                      {.7, {.03114187, .03124674, .03870036, 1, 1, 1}},
                      {1.4, {.02777778, .02779989, .02881388, .06118057, .13573578, .65791346}},
                      {2, {.11111111, .11114523, .11262121, .15018951, .22278595, .68340009}}};
  for (const Row& row : rows) {
    for (std::size_t i = 0; i < angles.size(); ++i) {
      EXPECT_NEAR(fresnel_reflectance(std::cos(angles[i]), row.eta), row.values[i], 6e-9) << row.eta << " " << i;
    }
  }
}

TEST(FresnelReflectance, NormalIncidenceIsTheSquaredContrast) {
  for (const double eta : {.3, .75, 1.33, 3.5}) {
    EXPECT_NEAR(fresnel_reflectance(1.0, eta), std::pow((eta - 1) / (eta + 1), 2), 1e-16);
  }
}

TEST(FresnelReflectance, KeepsItsDigitsNearEqualIndices) {
  for (const double eta : {.4, 1 - 1e-3, 1 - 1e-9, 1 + 1e-12, 1 + 1e-6, 1.02, 1.5}) {
    for (const double c : {.05, .3, .6, .93, 1.0}) {
      const double reference = textbook_reflectance(c, eta).convert_to<double>();
      EXPECT_NEAR(fresnel_reflectance(c, eta), reference, 4e-15 * reference) << eta << " " << c;
    }
  }
}

TEST(FresnelReflectance, LimitsAreTheStatedOnes) {
  EXPECT_EQ(fresnel_reflectance(0.0, 1.0), 0);
  EXPECT_EQ(fresnel_reflectance(0.4, 1.0), 0);
  EXPECT_EQ(fresnel_transmittance(0.0, 1.0), 1);
  EXPECT_DOUBLE_EQ(fresnel_reflectance(0.0, 1.5), 1);
  EXPECT_DOUBLE_EQ(fresnel_reflectance(0.0, 1 + 1e-15), 1);
  EXPECT_EQ(fresnel_transmittance(0.0, 1.5), 0);
  EXPECT_EQ(fresnel_reflectance(0.0, 0.8), 1);
  EXPECT_EQ(fresnel_reflectance(0.59, 0.8), 1);  // critical cosine 0.6
  EXPECT_EQ(fresnel_transmittance(0.59, 0.8), 0);
  EXPECT_LT(fresnel_reflectance(0.61, 0.8), 1);
}

TEST(FresnelReflectance, TotalInternalReflectionHasNoDerivative) {
  const Jet2 f = fresnel_reflectance(Jet2(0.5, 0), Jet2(0.8, 1));
  EXPECT_EQ(f.a, 1);
  EXPECT_EQ(f.v[0], 0);
  EXPECT_EQ(f.v[1], 0);
}

TEST(FresnelReflectance, IsTheSameFromBothSidesOfTheRay) {
  for (const double eta : {1.1, 1.33, 2.4}) {
    for (const double c : {.02, .2, .5, .8, 1.0}) {
      const double refracted = std::sqrt(1 - (1 - c * c) / (eta * eta));
      EXPECT_NEAR(fresnel_reflectance(c, eta), fresnel_reflectance(refracted, 1 / eta), 2e-14);
    }
  }
}

TEST(FresnelTransmittance, ComplementsTheReflectance) {
  for (const double eta : {.3, .9, 1 - 1e-9, 1.0, 1 + 1e-9, 1.3, 3.0}) {
    for (const double c : {0.0, 1e-3, .3, .97, 1.0}) {
      if (eta != 1 && c == 0) continue;
      EXPECT_NEAR(fresnel_reflectance(c, eta) + fresnel_transmittance(c, eta), 1, 1e-15) << eta << " " << c;
    }
  }
  // Grazing light: 4 c (eta^2 + 1)/s to first order, where 1 - reflectance has no digit left.
  EXPECT_NEAR(fresnel_transmittance(1e-18, 1.5) / (2e-18 * (1 + 2.25) / std::sqrt(1.25)), 1, 1e-14);
}

TEST(FresnelReflectance, DualNumbersGiveTheDerivative) {
  const Wide h("1e-20");
  for (const double eta : {.8, 1 + 1e-6, 1.4}) {
    for (const double c : {.65, .9}) {
      const Jet2 f = fresnel_reflectance(Jet2(c, 0), Jet2(eta, 1));
      const Jet2 t = fresnel_transmittance(Jet2(c, 0), Jet2(eta, 1));
      const Wide dc = (textbook_reflectance(c + h, eta) - textbook_reflectance(c - h, eta)) / (2 * h);
      const Wide de = (textbook_reflectance(c, eta + h) - textbook_reflectance(c, eta - h)) / (2 * h);
      EXPECT_NEAR(Wide(f.v[0] / dc).convert_to<double>(), 1, 1e-12);
      EXPECT_NEAR(Wide(f.v[1] / de).convert_to<double>(), 1, 1e-12);
      EXPECT_NEAR(t.v[0], -f.v[0], 1e-13 * (1 + std::abs(f.v[0])));
      EXPECT_NEAR(t.v[1], -f.v[1], 1e-13 * (1 + std::abs(f.v[1])));
    }
  }
}

TEST(DiffuseReflectance, AgreesWithTheTabulatedMoments) {
  struct Row {
    double eta, internal, external, a;
  };
  // Nine-digit quadrature, science table of the project: eta, 2 C1(eta), 2 C1(1/eta), A.
  const Row rows[] = {{1.1, .194344923, .025157357, 1.4824519},  {1.2, .336305740, .044280266, 2.0134357},
                      {1.3, .444456701, .061131825, 2.6000794},  {1.33, .471949149, .065930849, 2.7875140},
                      {1.35, .489207813, .069081240, 2.9154867}, {1.4, .528985482, .076811546, 3.2461536},
                      {1.45, .564502715, .084366959, 3.5924511}, {1.5, .596345760, .091777959, 3.9547355},
                      {1.6, .650877175, .106245568, 4.7286429},  {1.8, .732732855, .134054449, 6.4831495},
                      {2.0, .790149159, .160596637, 8.5305789},  {1.0001, .000233255, .0000332917, 1.0004666}};
  for (const Row& row : rows) {
    EXPECT_NEAR(diffuse_reflectance_internal(row.eta), row.internal, 1e-9) << row.eta;
    EXPECT_NEAR(diffuse_reflectance_external(row.eta), row.external, 1e-9) << row.eta;
    EXPECT_NEAR(diffuse_reflectance_internal(1 / row.eta), row.external, 1e-9) << row.eta;
    EXPECT_NEAR(dipole_boundary_a(row.eta), row.a, 6e-8) << row.eta;
  }
}

TEST(DiffuseReflectance, EqualsQuadratureOfTheTextbookEquations) {
  for (const char* text : {"0.3", "0.75", "0.999999999", "1.000000001", "1.3", "2.0", "3.4", "3.7", "8"}) {
    const Wide eta(text);
    const Wide external = diffuse_reflectance_external(eta), internal = diffuse_reflectance_internal(eta);
    EXPECT_LT(abs(Wide(external / mean_by_quadrature(eta) - 1)), Wide("1e-28")) << text;
    EXPECT_LT(abs(Wide(internal / mean_by_quadrature(1 / eta) - 1)), Wide("1e-28")) << text;
  }
}

TEST(DiffuseReflectance, EqualsDunklesClosedForm) {
  for (const char* text : {"1.01", "1.2", "1.5", "2.2", "3.5", "3.6", "20"}) {
    const Wider n(text);
    EXPECT_LT(abs(Wider(diffuse_reflectance_external(n) / dunkle(n) - 1)), Wider("1e-80")) << text;
  }
}

TEST(DiffuseReflectance, IsWithinTenUnitsInTheLastPlace) {
  std::vector<double> etas = {1 - 1e-3, 1 - 1e-9, 1 - 1e-15, 1 + 1e-15, 1 + 1e-9, 1 + 1e-6, 1 + 1e-3};
  for (double eta = 0.3; eta < 3.5; eta += 0.0371) etas.push_back(eta);
  for (const double eta : etas) {
    const Wider wide = eta;
    EXPECT_LT(ulps(diffuse_reflectance_external(eta), diffuse_reflectance_external(wide)), 10) << eta;
    EXPECT_LT(ulps(diffuse_reflectance_internal(eta), diffuse_reflectance_internal(wide)), 10) << eta;
    EXPECT_LT(ulps(diffuse_transmittance_external(eta), Wider(1 - diffuse_reflectance_external(wide))), 10) << eta;
    EXPECT_LT(ulps(diffuse_transmittance_internal(eta), Wider(1 - diffuse_reflectance_internal(wide))), 10) << eta;
    EXPECT_LT(ulps(dipole_boundary_a(eta), dipole_boundary_a(wide)), 10) << eta;
  }
}

TEST(DiffuseReflectance, HoldsItsStatedErrorFarOut) {
  for (const double eta : {1e-6, 1e-3, .1, 10.0, 1e3, 1e6}) {
    const Wider wide = eta, external = diffuse_reflectance_external(wide);
    EXPECT_LT(abs(Wider(diffuse_reflectance_external(eta) / external - 1)), Wider(1e-14)) << eta;
    EXPECT_LT(abs(Wider(diffuse_transmittance_external(eta) - (1 - external))), Wider(1e-15)) << eta;
  }
}

TEST(DiffuseReflectance, SidesAreTiedByReciprocity) {
  for (const double eta : {.4, .8, 1.2, 2.8}) {
    const double outside = 1 - diffuse_reflectance_external(eta), inside = 1 - diffuse_reflectance_internal(eta);
    EXPECT_NEAR(outside, eta * eta * inside, 1e-14 * (1 + eta * eta));
  }
}

TEST(DiffuseReflectance, VanishesWithoutBoundaryAndHasTheRightHandDerivative) {
  const Jet1 eta(1.0, 0);
  EXPECT_EQ(diffuse_reflectance_external(1.0), 0);
  EXPECT_EQ(diffuse_reflectance_internal(1.0), 0);
  EXPECT_EQ(diffuse_transmittance_internal(1.0), 1);
  EXPECT_EQ(dipole_boundary_a(1.0), 1);
  const double h = 1e-7;
  EXPECT_NEAR(diffuse_reflectance_external(eta).v[0], diffuse_reflectance_external(1 + h) / h, 1e-5);
  EXPECT_NEAR(diffuse_reflectance_internal(eta).v[0], diffuse_reflectance_internal(1 + h) / h, 1e-5);
  EXPECT_NEAR(diffuse_transmittance_internal(eta).v[0], -7.0 / 3, 1e-15);
  EXPECT_NEAR(diffuse_reflectance_external(1 - h) / h, 7.0 / 3, 1e-5);
}

TEST(DiffuseReflectance, DualNumbersGiveTheDerivative) {
  const Wider h("1e-30");
  for (const double eta : {.3, .7, 1 - 1e-6, 1 + 1e-6, 1.3, 1.9, 3.5, 4.0}) {
    const Wider external =
        (diffuse_reflectance_external(Wider(eta + h)) - diffuse_reflectance_external(Wider(eta - h))) / (2 * h);
    const Wider internal =
        (diffuse_reflectance_internal(Wider(eta + h)) - diffuse_reflectance_internal(Wider(eta - h))) / (2 * h);
    const Wider a = (dipole_boundary_a(Wider(eta + h)) - dipole_boundary_a(Wider(eta - h))) / (2 * h);
    const Jet1 jet(eta, 0);
    EXPECT_NEAR(Wider(diffuse_reflectance_external(jet).v[0] / external).convert_to<double>(), 1, 1e-13) << eta;
    EXPECT_NEAR(Wider(diffuse_reflectance_internal(jet).v[0] / internal).convert_to<double>(), 1, 1e-13) << eta;
    EXPECT_NEAR(Wider(dipole_boundary_a(jet).v[0] / a).convert_to<double>(), 1, 1e-13) << eta;
  }
}

TEST(ExitLobe, NormalisationIsTheMeanTransmittanceOutside) {
  EXPECT_NEAR(exit_lobe_normalisation(1.3, ExitLobe::normalised), 1 - .061131825, 1e-9);
  EXPECT_NEAR(exit_lobe_normalisation(1.5, ExitLobe::normalised), 1 - .091777959, 1e-9);
  EXPECT_EQ(exit_lobe_normalisation(1.5, ExitLobe::jensen), 1);
}

}  // namespace
}  // namespace opaline
