// Every registered profile keeps the contract of profile.h.
#include "model/profiles/profile.h"

#include "tests/support/profile_cases.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace opaline {
namespace {

struct Case {
  const ProfileInfo* info;
  Medium<double> medium;
  ProfileParameters parameters;
};

double mean_free_path(const Medium<double>& m) { return 1 / (m.sigma_a + m.sigma_s_prime); }

/// Each profile with media inside its domain, absorbing and not, down to its smallest albedo, with its parameters.
std::vector<Case> all_cases() {
  std::vector<Case> cases;
  for (const ProfileInfo& info : profiles()) {
    const double low = std::max(info.domain.alpha_prime_min, .05);
    const double eta_high = std::min(info.domain.eta_max, 1.5), eta_low = std::max(info.domain.eta_min, 1.0);
    for (const double alpha : {low, .5 * (1 + low), .999, 1.0}) {
      const Medium<double> one{2 * (1 - alpha), 2 * alpha, std::clamp(1.3, eta_low, eta_high)};
      const Medium<double> two{.1 * (1 - alpha), .1 * alpha, eta_high};
      for (const auto& p : example_parameters(info, mean_free_path(one))) cases.push_back({&info, one, p});
      cases.push_back({&info, two, example_parameters(info, mean_free_path(two)).back()});
    }
  }
  return cases;
}

class ProfileContract : public testing::TestWithParam<Case> {
 protected:
  const ProfileInfo& info = *GetParam().info;
  const Medium<double> medium = GetParam().medium;
  const ProfileParameters parameters = GetParam().parameters;
  const std::unique_ptr<Profile> profile = info.make(medium, parameters);
  const double length = mean_free_path(medium);
};

TEST_P(ProfileContract, IsFiniteAndMonotone) {
  double before = profile->evaluate(0);
  EXPECT_TRUE(std::isfinite(before));
  for (double r = 1e-4 * length; r < 1e8 * length; r *= 1.1) {
    const double value = profile->evaluate(r);
    ASSERT_TRUE(std::isfinite(value) && value >= 0) << r;
    if (info.monotone) {
      ASSERT_LE(value, before * (1 + 1e-14)) << r;
    }
    if (info.monotone && r < 30 * length) {
      ASSERT_GT(value, 0) << r;
    }
    before = value;
  }
  EXPECT_EQ(profile->evaluate(std::numeric_limits<double>::max()), 0);
}

TEST_P(ProfileContract, TotalIsTheIntegral) {
  // The trapezoid rule in log r converges exponentially for a smooth profile.
  const double step = .05, core = profile->core_radius();
  double sum = 0;
  for (double t = -25; t < 45; t += step) {
    const double r = core * std::exp(t);
    sum += 2 * pi * r * r * profile->evaluate(r) * step;
  }
  EXPECT_NEAR(sum, profile->total(), (info.depends_on_medium ? 1e-9 : 1e-7) * profile->total());  // a table is only C1
  EXPECT_GE(profile->total(), 0);
  if (info.conserves_energy) {
    EXPECT_LE(profile->total(), 1 + 1e-9);
  }
}

TEST_P(ProfileContract, CumulativeGoesFromZeroToTheTotalByRings) {
  EXPECT_EQ(profile->cumulative(0), 0);
  EXPECT_NEAR(profile->cumulative(1e14 * length), profile->total(), 1e-11);
  EXPECT_LE(profile->cumulative(std::numeric_limits<double>::max()), profile->total());
  for (double r = .1 * length; r < 8 * length; r *= 1.7) {
    const double h = 1e-4 * r;
    const double slope = (profile->cumulative(r + h) - profile->cumulative(r - h)) / (2 * h);
    const double ring = 2 * pi * r * profile->evaluate(r);
    if (ring * r < 1e-7 * profile->total()) break;  // lost in the cumulative's rounding
    EXPECT_NEAR(slope, ring, 1e-6 * ring) << r;
  }
}

TEST_P(ProfileContract, TransmittanceIntegratesToItsTotal) {
  if (!info.has_transmittance) {
    EXPECT_EQ(profile->total_transmittance(), 0);
    return;
  }
  const double step = .05;
  double sum = 0, before = profile->transmittance(0);
  for (double t = -20; t < 25; t += step) {
    const double r = length * std::exp(t), value = profile->transmittance(r);
    ASSERT_TRUE(value >= 0 && value <= before * (1 + 1e-13)) << r;
    sum += 2 * pi * r * r * (before = value) * step;
  }
  EXPECT_NEAR(sum, profile->total_transmittance(), 1e-8 * profile->total_transmittance());
  EXPECT_LE(profile->total() + profile->total_transmittance(), 1 + 1e-12);
}

TEST_P(ProfileContract, ScalesWithTheCoefficients) {
  if (!info.depends_on_medium) GTEST_SKIP() << "does not depend on the medium";
  const double k = 3.7;
  const auto scaled =
      info.make({k * medium.sigma_a, k * medium.sigma_s_prime, medium.eta}, in_other_units(info, parameters, k));
  EXPECT_NEAR(scaled->total(), profile->total(), 1e-12);
  EXPECT_NEAR(scaled->core_radius() * k, profile->core_radius(), 1e-12 * profile->core_radius());
  for (double r = .01 * length; r < 10 * length; r *= 2) {
    const double expected = k * k * profile->evaluate(k * r);
    EXPECT_NEAR(scaled->evaluate(r), expected, 1e-12 * expected) << r;
  }
}

TEST_P(ProfileContract, GradientAgreesWithDifferences) {
  const auto value = [&](double a, double s, double e, double r) {
    return info.make({a, s, e}, parameters)->evaluate(r);
  };
  const double a = medium.sigma_a, s = medium.sigma_s_prime, e = medium.eta;
  for (double r = .03 * length; r < 8 * length; r *= 3) {
    const ProfileGradient g = profile->evaluate_with_gradient(r);
    EXPECT_NEAR(g.value, profile->evaluate(r), 1e-12 * g.value);
    const double hs = 1e-5 * s, he = 1e-5 * e, ha = 1e-5 * a;
    const double tolerance = std::max(1e-7, info.gradient_error) * g.value;
    EXPECT_NEAR(g.d_sigma_s_prime * s, (value(a, s + hs, e, r) - value(a, s - hs, e, r)) / (2e-5), tolerance);
    EXPECT_NEAR(g.d_eta * e, (value(a, s, e + he, r) - value(a, s, e - he, r)) / (2e-5), tolerance);
    if (a > 0) {
      EXPECT_NEAR(g.d_sigma_a * a, (value(a + ha, s, e, r) - value(a - ha, s, e, r)) / (2e-5), tolerance);
    }
    EXPECT_TRUE(std::isfinite(g.d_sigma_a));
  }
}

/// The shares cumulative/total of samples must be uniform: (chi^2 - 99)/sqrt(198) over 100 bins.
double uniformity_z(const Profile& profile, int count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::vector<double> bins(100, 0);
  for (int i = 0; i < count; ++i) {
    const double xi = static_cast<double>(random() >> 11) * 0x1p-53;
    const double share = profile.cumulative(profile.sample(xi)) / profile.total();
    bins[static_cast<std::size_t>(std::min(99.0, 100 * share))] += 1;
  }
  const double expected = count / 100.0;
  double chi2 = 0;
  for (const double n : bins) chi2 += (n - expected) * (n - expected) / expected;
  return (chi2 - 99) / std::sqrt(198.0);
}

TEST_P(ProfileContract, SamplesFollowTheCumulative) {
  if (profile->total() == 0) GTEST_SKIP() << "nothing to sample";
  EXPECT_LT(std::abs(uniformity_z(*profile, 30000, 7)), 4);
  for (const double xi : {0.0, 1e-300, .5, 1 - 0x1p-53}) {
    EXPECT_TRUE(std::isfinite(profile->sample(xi)) && profile->sample(xi) >= 0) << xi;
  }
}

std::string case_name(const testing::TestParamInfo<Case>& test) {
  return test.param.info->name + "_" + std::to_string(test.index);
}

INSTANTIATE_TEST_SUITE_P(Registry, ProfileContract, testing::ValuesIn(all_cases()), case_name);

std::string error_of(const ProfileInfo& info, const ProfileParameters& given) {
  try {
    info.make({.05, 1.0, 1.3}, given);
  } catch (const ProfileParameterError& e) {
    return e.what();
  }
  return {};
}

TEST(ProfileRegistry, ParametersAreCheckedAndNamed) {
  const ProfileInfo &multipole = *find_profile("multipole"), &tabulated = *find_profile("tabulated");
  EXPECT_EQ(error_of(multipole, {}), "");
  EXPECT_THAT(error_of(multipole, {{"thickness", 2.0}}), testing::HasSubstr("it has thickness_mm, index_below"));
  EXPECT_THAT(error_of(multipole, {{"thickness_mm", 0.0}}), testing::HasSubstr("0 is not in 1e-60 .. inf (mm)"));
  EXPECT_THAT(error_of(multipole, {{"thickness_mm", std::nan("")}}), testing::HasSubstr("is not in"));
  EXPECT_THAT(error_of(multipole, {{"thickness_mm", std::string("x")}}), testing::HasSubstr("a number"));
  EXPECT_THAT(error_of(tabulated, {}), testing::HasSubstr("profile tabulated: needs samples"));
  EXPECT_THAT(error_of(*find_profile("gaussian_sum"), {{"of", std::string("tabulated")}}),
              testing::HasSubstr("none of standard_dipole, better_dipole"));
  EXPECT_THAT(error_of(*find_profile("standard_dipole"), {{"g", .5}}), testing::HasSubstr("it has none"));
  const std::vector<Layer> two_half_spaces(2, Layer{{.1, 1, 1.3}});
  EXPECT_THAT(error_of(*find_profile("layered"), {{"thickness_mm", 3.0}, {"layers", two_half_spaces}}),
              testing::HasSubstr("layer 1: only the last layer may be infinitely thick"));
  EXPECT_THAT(error_of(*find_profile("layered"), {{"layers", std::vector<Layer>(1, Layer{{.1, 1, 1.3}})}}),
              testing::HasSubstr("the top layer needs a finite thickness"));
}

TEST(ProfileRegistry, DomainIsData) {
  const ProfileInfo& multipole = *find_profile("multipole");
  EXPECT_TRUE(multipole.outside_domain({.01, 1, 1.3}, {{"thickness_mm", 4.0}}).empty());
  EXPECT_EQ(multipole.outside_domain({1, 1, 4}, {{"thickness_mm", .5}}).size(), 3u);
  const std::vector<Layer> below = {Layer{{.01, 1, 1.3}, 1.0}, Layer{{1, 1, 1.3}}};
  EXPECT_EQ(find_profile("layered")->outside_domain({.01, 1, 1.3}, {{"thickness_mm", 4.0}, {"layers", below}}).size(),
            2u);
  EXPECT_FALSE(find_profile("tabulated")->needs_medium_alone());
  EXPECT_TRUE(find_profile("directional_dipole")->depends_on_direction);
}

TEST(ProfileRegistry, SamplesFollowTheCumulativeInManyBins) {
  for (const ProfileInfo& info : profiles()) {
    const ProfileParameters p = example_parameters(info, 1).back();
    EXPECT_LT(std::abs(uniformity_z(*info.make({.05, 1.0, 1.3}, p), 200000, 20)), 4) << info.name;
  }
}

TEST(ProfileRegistry, FindsByNameAndNamesAreUnique) {
  ASSERT_FALSE(profiles().empty());
  for (const ProfileInfo& info : profiles()) {
    EXPECT_EQ(find_profile(info.name), &info);
    EXPECT_FALSE(info.citation.empty());
    EXPECT_LT(info.domain.eta_min, info.domain.eta_max);
  }
  EXPECT_EQ(find_profile("no such profile"), nullptr);
  EXPECT_EQ(profiles().front().name, "standard_dipole");
}

}  // namespace
}  // namespace opaline
