// Covariances, intervals and words, from Jacobians whose inverse is known.
#include "fit/uncertainty.h"
#include "tests/support/fit_fixture.h"

#include <gmock/gmock.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <random>

namespace opaline {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Solution solution_with(const Eigen::MatrixXd& jacobian) {
  Solution s;
  s.parameters = to_parameters(test::library_material("skin1"), {});
  s.jacobian = jacobian;
  s.converged = true;
  return s;
}

/// Columns of these standard deviations, uncorrelated.
Eigen::MatrixXd diagonal(const std::array<double, parameter_count>& sd) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(parameter_count, parameter_count);
  for (std::size_t i = 0; i < parameter_count; ++i)
    jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)) = 1 / sd[i];
  return jacobian;
}

Eigen::MatrixXd random_jacobian(Eigen::Index rows) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::NullaryExpr(rows, parameter_count, [&] { return normal(random); });
  for (int i = 0; i < parameter_count; ++i) jacobian.col(i) *= std::pow(10, i - 2);  // scales far apart
  return jacobian;
}

TEST(Uncertainty, OfIndependentColumnsIsTheInverseOfEach) {
  const std::array<double, parameter_count> sd = {0.01, 0.02, 0.3, 0.04, 0.05, 0.06, 0.01};
  const Solution s = solution_with(diagonal(sd));
  const Uncertainty u = uncertainty(s, {});
  EXPECT_NEAR(u.condition, 1, 1e-9);
  EXPECT_LT((u.correlation - Eigen::MatrixXd::Identity(7, 7)).norm(), 1e-12);
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const ParameterEstimate& e = u.parameters[i];
    const int index = static_cast<int>(i);
    EXPECT_DOUBLE_EQ(e.value, natural_value(index, s.parameters[i]));
    EXPECT_NEAR(e.sd / (index == eta_index ? sd[i] : sd[i] * e.value), 1, 1e-12);
    EXPECT_NEAR(e.low, natural_value(index, s.parameters[i] - 1.959964 * sd[i]), 1e-6 * e.value);
    EXPECT_NEAR(e.high, natural_value(index, s.parameters[i] + 1.959964 * sd[i]), 1e-6 * e.value);
    EXPECT_EQ(e.identifiable, i != 2) << "0.3 is more than a factor of 2 wide";
    EXPECT_EQ(e.reason.empty(), i != 2);
  }
  EXPECT_TRUE(u.notes.empty());
}

TEST(Uncertainty, IsTheInverseOfTheInformation) {
  const Eigen::MatrixXd jacobian = random_jacobian(30);
  const Uncertainty u = uncertainty(solution_with(jacobian), {});
  const Eigen::MatrixXd expected = (jacobian.transpose() * jacobian).inverse();
  for (int i = 0; i < parameter_count; ++i)
    for (int j = 0; j < parameter_count; ++j) {
      const double scale = std::sqrt(expected(i, i) * expected(j, j));
      EXPECT_NEAR(u.covariance(i, j) / scale, expected(i, j) / scale, 1e-9);
      EXPECT_NEAR(u.correlation(i, j), expected(i, j) / scale, 1e-9);
    }
}

TEST(Uncertainty, OfAFewFreeParametersLeavesOutTheOthers) {
  const Eigen::MatrixXd jacobian = random_jacobian(30);
  SolveSettings settings;
  settings.free = parse_free("sigma_a");
  const Uncertainty u = uncertainty(solution_with(jacobian), settings.free);
  const Eigen::MatrixXd expected = (jacobian.leftCols(3).transpose() * jacobian.leftCols(3)).inverse();
  EXPECT_LT((u.covariance.topLeftCorner(3, 3) - expected).norm(), 1e-9 * expected.norm());
  EXPECT_EQ(u.covariance.rightCols(4).norm(), 0);
  EXPECT_EQ(u.covariance.bottomRows(4).norm(), 0);
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const ParameterEstimate& e = u.parameters[i];
    EXPECT_EQ(e.free, i < 3);
    if (e.free) continue;
    EXPECT_EQ(e.sd, 0);
    EXPECT_EQ(e.low, e.value);
    EXPECT_EQ(e.high, e.value);
    EXPECT_TRUE(e.identifiable);
    EXPECT_EQ(u.correlation(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)), 1);
  }
}

TEST(Uncertainty, WhatTheDataDoNotTellApartIsNotKnown) {
  Eigen::MatrixXd jacobian = random_jacobian(30);
  const Uncertainty regular = uncertainty(solution_with(jacobian), {});
  jacobian.col(3) = -2 * jacobian.col(0);
  const Uncertainty u = uncertainty(solution_with(jacobian), {});
  for (const std::size_t i : {0u, 3u}) {
    EXPECT_GT(u.parameters[i].sd, 1e4 * regular.parameters[i].sd);
    EXPECT_FALSE(u.parameters[i].identifiable);
    EXPECT_FALSE(u.parameters[i].reason.empty());
    EXPECT_NEAR(u.parameters[i].low, 1e-6, 1e-12);  // the bounds
    EXPECT_NEAR(u.parameters[i].high, 1e4, 1e-6);
  }
  EXPECT_GT(u.condition, 1e7);
  EXPECT_NEAR(u.correlation(0, 3), 1, 1e-6);
  // The others do not suffer.
  for (const std::size_t i : {1u, 2u, 4u, 5u, 6u}) EXPECT_LT(u.parameters[i].sd, 1.001 * regular.parameters[i].sd) << i;
}

TEST(Uncertainty, NotesNameWhatTradesOff) {
  Eigen::MatrixXd jacobian = 1e3 * diagonal({1, 1, 1, 1, 1, 1, 1});
  jacobian(0, 5) = 1e4;
  Solution s = solution_with(jacobian);
  EXPECT_THAT(uncertainty(s, {}).notes,
              ElementsAre(HasSubstr("sigma_a_per_mm[R] and sigma_s_prime_per_mm[B] trade off (correlation -0.995)")));
  s.converged = false;
  EXPECT_THAT(uncertainty(s, {}).notes, Contains(HasSubstr("did not converge")));
}

TEST(Uncertainty, AParameterWithoutInfluenceIsNotKnown) {
  Eigen::MatrixXd jacobian = random_jacobian(30);
  jacobian.col(1).setZero();
  jacobian.col(4).setZero();
  jacobian.col(eta_index).setZero();
  const Uncertainty u = uncertainty(solution_with(jacobian), {});
  EXPECT_TRUE(u.covariance.allFinite());
  EXPECT_FALSE(u.alpha_prime[1].identifiable);
  for (const std::size_t i : {std::size_t{1}, std::size_t{4}, std::size_t{eta_index}}) {
    EXPECT_GT(u.parameters[i].sd, 1e4);
    EXPECT_FALSE(u.parameters[i].identifiable);
  }
  EXPECT_EQ(u.parameters[eta_index].low, 1.05);
  EXPECT_EQ(u.parameters[eta_index].high, 2.0);
  EXPECT_TRUE(u.correlation.allFinite());
  for (int i = 0; i < parameter_count; ++i)
    for (int j = 0; j < parameter_count; ++j) EXPECT_LE(std::abs(u.correlation(i, j)), 1 + 1e-12);
  EXPECT_LT(u.parameters[0].sd, 1);
  for (const ParameterEstimate& alpha : u.alpha_prime) EXPECT_TRUE(std::isfinite(alpha.sd));
}

TEST(Uncertainty, OfAlphaPrimeIsThatOfItsDistribution) {
  Eigen::MatrixXd jacobian = random_jacobian(40);
  for (int i = 0; i < parameter_count; ++i) jacobian.col(i) *= 20 / jacobian.col(i).norm();  // sd about 0.05
  jacobian.col(4) += 0.9 * jacobian.col(1);
  const Solution s = solution_with(jacobian);
  const Uncertainty u = uncertainty(s, {});
  const Eigen::MatrixXd root = u.covariance.llt().matrixL();
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  constexpr int samples = 40000;
  std::array<double, 3> sum{}, square{};
  for (int k = 0; k < samples; ++k) {
    const Eigen::VectorXd step = root * Eigen::VectorXd::NullaryExpr(parameter_count, [&] { return normal(random); });
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = std::exp(s.parameters[c] + step[static_cast<Eigen::Index>(c)]),
                   scattering = std::exp(s.parameters[c + 3] + step[static_cast<Eigen::Index>(c) + 3]);
      const double alpha = scattering / (a + scattering);
      sum[c] += alpha / samples;
      square[c] += alpha * alpha / samples;
    }
  }
  for (std::size_t c = 0; c < 3; ++c) {
    const ParameterEstimate& e = u.alpha_prime[c];
    const double sd = std::sqrt(square[c] - sum[c] * sum[c]);
    EXPECT_NEAR(e.sd / sd, 1, 0.03) << c;
    EXPECT_NEAR(e.value, sum[c], 0.1 * sd);
    EXPECT_NEAR(e.high - e.low, 2 * 1.96 * e.sd, 1e-3 * e.sd);
  }
}

TEST(Uncertainty, AlphaPrimeIsKnownOrNotAgainstTheAbsorbedShare) {
  const Uncertainty known = uncertainty(solution_with(diagonal({0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1})), {}),
                    unknown = uncertainty(solution_with(diagonal({3, 3, 3, 3, 3, 3, 0.1})), {});
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_TRUE(known.alpha_prime[c].identifiable);
    EXPECT_TRUE(known.alpha_prime[c].reason.empty());
    EXPECT_FALSE(unknown.alpha_prime[c].identifiable);
    EXPECT_THAT(unknown.alpha_prime[c].reason, HasSubstr("1 - alpha'"));
    EXPECT_GE(unknown.alpha_prime[c].low, 0);
    EXPECT_LE(unknown.alpha_prime[c].high, 1);
  }
}

TEST(Uncertainty, AValueAtItsBoundIsNotIdentified) {
  SolveSettings settings;
  Solution s = solution_with(diagonal({0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01}));
  s.parameters[2] = std::log(settings.bounds.sigma_min);
  s.parameters[eta_index] = settings.bounds.eta_max;
  const Uncertainty u = uncertainty(s, settings.free);
  for (const std::size_t i : {std::size_t{2}, std::size_t{eta_index}}) {
    EXPECT_FALSE(u.parameters[i].identifiable);
    EXPECT_THAT(u.parameters[i].reason, HasSubstr("bound"));
  }
  EXPECT_TRUE(u.parameters[0].identifiable);
  EXPECT_DOUBLE_EQ(u.parameters[2].low, settings.bounds.sigma_min);
  EXPECT_EQ(u.parameters[eta_index].high, settings.bounds.eta_max);
}

TEST(Uncertainty, ValuesOfOtherStartsThatFitAsWellBelongToTheInterval) {
  Solution s = solution_with(diagonal({0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.01}));
  s.starts.resize(3);
  for (StartRecord& start : s.starts) start.to = s.parameters;
  s.starts[1].to[0] += 1.2, s.starts[1].to[3] += 1.2, s.starts[1].to[eta_index] += 0.52;
  s.starts[1].excess = 0.4;
  s.starts[2].to[1] -= 1.2;
  s.starts[2].excess = 5;  // the data tell this one apart
  const Uncertainty u = uncertainty(s, {});
  for (const std::size_t i : {std::size_t{0}, std::size_t{3}, std::size_t{eta_index}}) {
    EXPECT_FALSE(u.parameters[i].identifiable) << i;
    EXPECT_THAT(u.parameters[i].reason, HasSubstr("other starts"));
    EXPECT_DOUBLE_EQ(u.parameters[i].high, natural_value(static_cast<int>(i), s.starts[1].to[i]));
  }
  for (const std::size_t i : {1u, 2u, 4u, 5u}) EXPECT_TRUE(u.parameters[i].identifiable) << i;
  EXPECT_TRUE(u.alpha_prime[0].identifiable);  // both grew alike
}

TEST(Uncertainty, AWideIntervalOfEtaIsNotIdentified) {
  const Uncertainty u = uncertainty(solution_with(diagonal({0.01, 0.01, 0.01, 0.01, 0.01, 0.01, 0.2})), {});
  EXPECT_FALSE(u.parameters[eta_index].identifiable);
  EXPECT_THAT(u.parameters[eta_index].reason, HasSubstr("half of its range"));
}

}  // namespace
}  // namespace opaline
