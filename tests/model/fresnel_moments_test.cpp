#include "model/fresnel_moments.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>
#include <boost/math/quadrature/tanh_sinh.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <limits>

namespace opaline {
namespace {

using Wide = boost::multiprecision::cpp_bin_float_50;
using Jet1 = ceres::Jet<double, 1>;

/// 3 int F c^2 dc of the textbook equations, split at the critical cosine.
Wide moment_by_quadrature(const Wide& eta) {
  static boost::math::quadrature::tanh_sinh<Wide> rule;
  const auto reflectance = [&](const Wide& c) {
    const Wide sin2_t = (1 - c * c) / (eta * eta);
    if (sin2_t >= 1) return Wide(1);
    const Wide t = sqrt(Wide(1 - sin2_t));
    const Wide r_s = (c - eta * t) / (c + eta * t), r_p = (eta * c - t) / (eta * c + t);
    return Wide((r_s * r_s + r_p * r_p) / 2);
  };
  const Wide critical = eta < 1 ? Wide(sqrt(Wide(1 - eta * eta))) : Wide(0);
  const auto integrand = [&](const Wide& c) { return Wide(3 * c * c * reflectance(c)); };
  return critical * critical * critical + rule.integrate(integrand, critical, Wide(1), Wide("1e-30"));
}

double relative(double value, const Wide& reference) {
  return std::abs(Wide(value / reference - 1).convert_to<double>());
}

TEST(SecondMoment, AgreesWithTheTabulatedMoments) {
  struct Row {
    double eta, internal, external, a;
  };
  // Nine-digit quadrature, science table of the project: eta, 3 C2(eta), 3 C2(1/eta), modified A.
  const Row rows[] = {{1.1, .087919742, .009779387, 1.3503542},  {1.2, .198496178, .022161069, 1.8057956},
                      {1.3, .300266959, .035349881, 2.3405322},  {1.33, .328238524, .039413302, 2.5153610},
                      {1.35, .346206561, .042144289, 2.6355269}, {1.4, .388782824, .049038606, 2.9484926},
                      {1.45, .428127318, .056012513, 3.2793025}, {1.5, .464430522, .063048058, 3.6279330},
                      {1.6, .528777360, .077241512, 4.3789098},  {1.8, .630294873, .105763476, 6.0998701},
                      {2.0, .704870056, .133965083, 8.1241993},  {1.0001, .000003861, 6.3e-7, 1.0002372}};
  for (const Row& row : rows) {
    EXPECT_NEAR(second_moment_internal(row.eta), row.internal, 1e-9) << row.eta;
    EXPECT_NEAR(second_moment_external(row.eta), row.external, 1e-9) << row.eta;
    EXPECT_NEAR(second_moment_internal(1 / row.eta), row.external, 1e-9) << row.eta;
    EXPECT_NEAR(modified_boundary_a(row.eta), row.a, 6e-8) << row.eta;
  }
}

TEST(SecondMoment, EqualsQuadratureOfTheTextbookEquations) {
  for (const char* text : {"0.3", "0.75", "0.999999", "1.000001", "1.3", "2.0", "3.4"}) {
    const Wide eta(text);
    const Wide external = second_moment_external(eta), internal = second_moment_internal(eta);
    EXPECT_LT(abs(Wide(external / moment_by_quadrature(eta) - 1)), Wide("1e-25")) << text;
    EXPECT_LT(abs(Wide(internal / moment_by_quadrature(1 / eta) - 1)), Wide("1e-25")) << text;
  }
  for (const double eta : {3.6, 5.0, 30.0, 1e3, 1e6}) {
    EXPECT_LT(relative(second_moment_external(eta), moment_by_quadrature(eta)), 1e-12) << eta;
    EXPECT_LT(relative(second_moment_internal(eta), moment_by_quadrature(Wide(1 / Wide(eta)))), 1e-12) << eta;
  }
}

TEST(SecondMoment, HoldsItsStatedErrorInDouble) {
  const double bound = 60 * std::numeric_limits<double>::epsilon();
  for (double eta = 0.3; eta < 3.5; eta += 0.0371) {
    const Wide wide = eta;
    EXPECT_LT(relative(second_moment_external(eta), second_moment_external(wide)), bound) << eta;
    EXPECT_LT(relative(second_moment_internal(eta), second_moment_internal(wide)), bound) << eta;
    EXPECT_LT(relative(exitance_weight_flux(eta), exitance_weight_flux(wide)), bound) << eta;
    EXPECT_LT(relative(modified_boundary_a(eta), modified_boundary_a(wide)), bound) << eta;
  }
}

TEST(SecondMoment, TheWeightsConserveEnergy) {
  for (const double eta : {.3, .9, 1.0, 1.0001, 1.4, 3.5, 10.0}) {
    const double sum = exitance_weight_flux(eta) + 2 * modified_boundary_a(eta) * exitance_weight_fluence(eta);
    EXPECT_NEAR(sum, 1, 1e-14) << eta;
  }
}

TEST(SecondMoment, VanishesWithoutABoundaryWithItsDerivative) {
  EXPECT_EQ(second_moment_external(1.0), 0);
  EXPECT_EQ(second_moment_internal(1.0), 0);
  EXPECT_EQ(exitance_weight_flux(1.0), .5);
  EXPECT_EQ(exitance_weight_fluence(1.0), .25);
  EXPECT_EQ(modified_boundary_a(1.0), 1);
  EXPECT_EQ(second_moment_internal(Jet1(1.0, 0)).v[0], 0);
  EXPECT_NEAR(second_moment_internal(1 + 1e-8) / 1e-8, 0, 1e-3);
  EXPECT_NEAR(modified_boundary_a(Jet1(1.0, 0)).v[0], 7.0 / 3, 1e-14);
}

TEST(SecondMoment, DualNumbersGiveTheDerivative) {
  const Wide h("1e-16");
  for (const double eta : {.3, .7, 1 + 1e-6, 1.3, 1.9, 3.5}) {
    const Wide a = (modified_boundary_a(Wide(eta + h)) - modified_boundary_a(Wide(eta - h))) / (2 * h);
    const Wide c = (exitance_weight_flux(Wide(eta + h)) - exitance_weight_flux(Wide(eta - h))) / (2 * h);
    EXPECT_LT(relative(modified_boundary_a(Jet1(eta, 0)).v[0], a), 1e-12) << eta;
    EXPECT_LT(relative(exitance_weight_flux(Jet1(eta, 0)).v[0], c), 1e-12) << eta;
  }
  const double jet = exitance_weight_flux(Jet1(4.0, 0)).v[0];
  EXPECT_NEAR(jet, (exitance_weight_flux(4 + 1e-5) - exitance_weight_flux(4 - 1e-5)) / 2e-5, 1e-9 * std::abs(jet));
}

}  // namespace
}  // namespace opaline
