#include "model/profiles/gaussian_sum.h"

#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

/// A profile that is one Gaussian, or several, to be found again.
class KnownGaussians final : public Profile {
 public:
  explicit KnownGaussians(std::vector<Gaussian> terms) : sum_{.terms = std::move(terms)} {}
  double evaluate(double r) const override { return sum_.evaluate(r); }
  ProfileGradient evaluate_with_gradient(double r) const override { return {evaluate(r), 0, 0, 0}; }
  double total() const override { return sum_.total(); }
  double cumulative(double r) const override { return sum_.cumulative(r); }
  double sample(double xi) const override { return sum_.sample(xi); }
  double core_radius() const override { return std::sqrt(sum_.terms.front().variance); }

 private:
  GaussianSum sum_;
};

TEST(GaussianSum, EveryProfileIsFittedBetterByMoreTerms) {
  for (const ProfileInfo& info : profiles()) {
    if (!info.needs_medium_alone() || info.name == "gaussian_sum") continue;
    const auto profile = info.make({.05, 1.0, 1.3});
    double before = 1;
    for (const int terms : {2, 3, 4, 6, 8, 12}) {
      const GaussianSum sum = fit_gaussian_sum(*profile, terms);
      EXPECT_NEAR(sum.total() / profile->total(), 1, 1e-5) << info.name;
      EXPECT_LT(sum.flux_error, before) << info.name << " " << terms;
      EXPECT_LE(static_cast<int>(sum.terms.size()), terms);
      for (const Gaussian& g : sum.terms) EXPECT_GT(g.weight, 0);
      before = sum.flux_error;
    }
    EXPECT_LT(before, .01) << info.name;
  }
}

TEST(GaussianSum, FindsGaussiansAgain) {
  const KnownGaussians known({{.3, .04}, {.5, 1.7}});
  const GaussianSum sum = fit_gaussian_sum(known, 32);
  EXPECT_LT(sum.flux_error, 6e-3);
  EXPECT_LT(sum.worst_relative, 2e-2);
}

TEST(GaussianSum, StatedErrorIsTheRealOne) {
  const auto profile = find_profile("standard_dipole")->make({.05, 1.0, 1.3});
  const GaussianSum sum = fit_gaussian_sum(*profile, 5);
  double difference = 0;
  for (double r = .0005; r < 200; r += .001) {
    difference += .001 * 2 * pi * r * std::abs(sum.evaluate(r) - profile->evaluate(r));
  }
  EXPECT_NEAR(sum.flux_error, difference / profile->total(), .02 * sum.flux_error);
}

TEST(GaussianSum, CumulativeIntegratesAndSampleInvertsTheTerms) {
  const GaussianSum sum{.terms = {{.25, .5}, {.75, 8}}};
  double integral = 0;
  for (double r = .0005; r < 3; r += .001) integral += .001 * 2 * pi * r * sum.evaluate(r);
  EXPECT_NEAR(integral, sum.cumulative(3), 1e-6);
  EXPECT_DOUBLE_EQ(sum.total(), 1);
  EXPECT_NEAR(sum.sample(.125), std::sqrt(std::log(2.0)), 1e-14);       // median of the first term
  EXPECT_NEAR(sum.sample(.625), std::sqrt(16 * std::log(2.0)), 1e-14);  // and of the second
  EXPECT_TRUE(std::isfinite(sum.sample(1 - 0x1p-53)));
}

TEST(GaussianSum, NothingIsFittedToNothing) {
  const auto dark = find_profile("standard_dipole")->make({1, 0, 1.3});
  EXPECT_TRUE(fit_gaussian_sum(*dark, 4).terms.empty());
}

}  // namespace
}  // namespace opaline
