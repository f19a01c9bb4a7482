// The Fresnel factors between the nodes in eta.
#include "fit/eta_nodes.h"
#include "model/fresnel.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace opaline {
namespace {

TEST(EtaNodes, LieInsideTheRangeAndSumToOne) {
  const EtaNodes nodes(1.05, 2, 8);
  ASSERT_EQ(nodes.size(), 8);
  for (const double eta : nodes.etas()) {
    EXPECT_GT(eta, 1.05);
    EXPECT_LT(eta, 2);
  }
  for (double eta = 1.05; eta <= 2; eta += 0.0137) {
    const std::vector<double> basis = nodes.basis(eta);
    EXPECT_NEAR(std::accumulate(basis.begin(), basis.end(), 0.0), 1, 1e-13) << eta;
  }
}

TEST(EtaNodes, EachIsOneAtItsNodeAndZeroAtTheOthers) {
  const EtaNodes nodes(1.1, 1.8, 5);
  for (int k = 0; k < nodes.size(); ++k) {
    const std::vector<double> basis = nodes.basis(nodes.etas()[static_cast<std::size_t>(k)]);
    for (int j = 0; j < nodes.size(); ++j) EXPECT_NEAR(basis[static_cast<std::size_t>(j)], j == k ? 1 : 0, 1e-13);
  }
}

/// What a pixel sees of a beam: the entering flux and the leaving factor.
double seen(double eta, double mu_i, double mu_o) {
  return fresnel_transmittance(mu_i, eta) * mu_i * fresnel_transmittance(mu_o, eta);
}

double worst_interpolation(const EtaNodes& nodes) {
  double worst = 0;
  for (double eta = 1.05; eta < 2.001; eta += 0.95 / 64) {
    const std::vector<double> basis = nodes.basis(std::min(eta, 2.0));
    for (double mu_i = 0.01; mu_i <= 1; mu_i += 0.03)
      for (double mu_o = 0.05; mu_o <= 1; mu_o += 0.05) {
        double sum = 0;
        for (std::size_t k = 0; k < basis.size(); ++k) sum += basis[k] * seen(nodes.etas()[k], mu_i, mu_o);
        worst = std::max(worst, std::abs(sum - seen(std::min(eta, 2.0), mu_i, mu_o)));
      }
  }
  return worst;
}

TEST(EtaNodes, EightInterpolateTheProductOfBothFresnelFactors) {
  EXPECT_LT(worst_interpolation(EtaNodes(1.05, 2, 8)), 5e-6);
  EXPECT_GT(worst_interpolation(EtaNodes(1.05, 2, 4)), 4e-5);  // the bound means something
}

TEST(EtaNodes, DerivativesAgreeWithDifferences) {
  using Jet = ceres::Jet<double, 1>;
  const EtaNodes nodes(1.05, 2, 8);
  for (const double eta : {1.06, 1.2, 1.5, 1.93}) {
    const double h = 1e-6;
    const std::vector<Jet> basis = nodes.basis(Jet(eta, 0));
    const std::vector<double> above = nodes.basis(eta + h), below = nodes.basis(eta - h);
    for (std::size_t k = 0; k < basis.size(); ++k) {
      EXPECT_DOUBLE_EQ(basis[k].a, nodes.basis(eta)[k]);
      EXPECT_NEAR(basis[k].v[0], (above[k] - below[k]) / (2 * h), 1e-6 * (1 + std::abs(basis[k].v[0])));
    }
  }
}

TEST(EtaNodes, OneNodeIsAKnownEta) {
  const EtaNodes nodes(1.3);
  ASSERT_EQ(nodes.size(), 1);
  EXPECT_EQ(nodes.etas().front(), 1.3);
  for (const double eta : {1.0, 1.3, 1.9}) EXPECT_EQ(nodes.basis(eta), std::vector<double>{1.0});
}

}  // namespace
}  // namespace opaline
