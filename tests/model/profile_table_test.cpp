#include "model/profile_table.h"

#include "model/materials/library.h"
#include "model/profiles/profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// The profiles of the twelve materials of Jensen et al. 2001, one per colour channel.
std::vector<std::unique_ptr<Profile>> measured_profiles() {
  std::vector<std::unique_ptr<Profile>> all;
  for (const MaterialRow& row : material_library()) {
    if (row.set != "jensen2001") continue;
    for (std::size_t c = 0; c < 3; ++c)
      all.push_back(find_profile("standard_dipole")->make({row.sigma_a[c], row.sigma_s_prime[c], row.eta}));
  }
  return all;
}

ProfileTable table_of(const Profile& profile, double r_max) {
  return ProfileTable([&profile](double r) { return profile.evaluate(r); }, profile.core_radius(), r_max);
}

/// -d ln R / d ln r.
double exponent(const Profile& profile, double r) {
  return std::log(profile.evaluate(r * (1 - 1e-4)) / profile.evaluate(r * (1 + 1e-4))) / 2e-4;
}

struct Sample {
  float r2;
  double r, exact;
};

/// Logarithmic radii from a thousandth of the core radius to 100 of it, rounded to what a float r^2 can say.
std::vector<Sample> samples_of(const Profile& profile, int count) {
  std::vector<Sample> samples = {{0.0f, 0.0, profile.evaluate(0)}};
  for (int i = 0; i < count; ++i) {
    const double wish = profile.core_radius() * 1e-3 * std::pow(1e5, (i + 0.5) / count);
    const float r2 = static_cast<float>(wish * wish);
    const double r = std::sqrt(static_cast<double>(r2));
    samples.push_back({r2, r, profile.evaluate(r)});
  }
  return samples;
}

// The limits are those the header states; measured: 3.2e-7, 5.8e-7, and 4.7e-6, 1.0e-5, 8.0e-5, 1.2e-3.
TEST(ProfileTable, IsAsExactAsTheHeaderSays) {
  const int count = 4000;
  struct Limit {
    double exponent, error;
  };
  const Limit limits[] = {{3.5, 5e-6}, {5, 1e-5}, {10, 1e-4}, {20, 2e-3}};
  for (const auto& profile : measured_profiles()) {
    const ProfileTable table = table_of(*profile, 100 * profile->core_radius());
    double integral = 0;
    for (const Sample& s : samples_of(*profile, count)) {
      const double error = std::abs(static_cast<double>(table(s.r2)) - s.exact);
      EXPECT_LE(error, 5e-7 * profile->evaluate(0)) << s.r;
      integral += error * 2 * pi * s.r * s.r * std::log(1e5) / count;
      const double steep = s.r > 0 ? exponent(*profile, s.r) : 0;
      const auto* limit =
          std::find_if(std::begin(limits), std::end(limits), [&](Limit l) { return steep < l.exponent; });
      if (limit != std::end(limits)) {
        EXPECT_LE(error, limit->error * s.exact) << s.r << " falls as r^-" << steep;
      }
    }
    EXPECT_LE(integral, 1e-6 * profile->total());
  }
}

TEST(ProfileTable, StaysInItsLastSegmentBeyondTheLargestRadius) {
  const auto profile = find_profile("standard_dipole")->make({0.0011, 2.55, 1.3});
  const ProfileTable table = table_of(*profile, 10);
  EXPECT_EQ(table.r_max(), 10);
  const double highest = profile->evaluate(std::sqrt(100 / 1.126)), lowest = profile->evaluate(std::sqrt(100 * 1.126));
  for (const float r2 : {120.0f, 777.0f, 1e4f, 1e12f, 1e30f}) {
    EXPECT_LE(static_cast<double>(table(r2)), highest) << r2;
    EXPECT_GE(static_cast<double>(table(r2)), lowest) << r2;
  }
}

TEST(ProfileTable, ReproducesCubicsExactly) {
  // R = x^3 - 2 x with x = r^2 is a cubic in every segment, so only float rounding is left.
  const auto cubic = [](double r) {
    const double x = r * r;
    return x * x * x - 2 * x + 30;
  };
  const ProfileTable table(cubic, 1.0, 3.0);
  for (double r = 0; r < 3; r += 0.01) EXPECT_NEAR(table(static_cast<float>(r * r)), cubic(r), 2e-4) << r;
}

TEST(ProfileTable, TakesTinyAndHugeScales) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    const auto bell = [scale](double r) { return 1 / (1 + r * r / (scale * scale)); };
    const ProfileTable table(bell, scale, 50 * scale);
    for (double r = 0; r < 50; r += 0.37)
      EXPECT_NEAR(table(static_cast<float>(r * r * scale * scale)), bell(r * scale), 1e-5 * bell(r * scale)) << r;
  }
}

TEST(ProfileTable, IsSmall) {
  // 100 core radii are 16 octaves of x = r^2 + x0, 8 segments each, 16 bytes a segment.
  const auto profile = find_profile("standard_dipole")->make({0.0011, 2.55, 1.3});
  EXPECT_LE(table_of(*profile, 100 * profile->core_radius()).bytes(), 2100u);
}

}  // namespace
}  // namespace opaline
