#include "model/profiles/tabulated_profile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

std::vector<ProfileSample> sampled(const Profile& profile, double low, double high, int count) {
  std::vector<ProfileSample> samples;
  for (int i = 0; i < count; ++i) {
    const double r = low * std::pow(high / low, i / (count - 1.0));
    samples.push_back({r, profile.evaluate(r)});
  }
  return samples;
}

TEST(TabulatedProfile, ReproducesTheProfileItCameFrom) {
  const auto dipole = find_profile("standard_dipole")->make({.05, 1.0, 1.3});
  const TabulatedProfile table(sampled(*dipole, .01, 40, 80));
  for (double r = .02; r < 39; r *= 1.13) EXPECT_NEAR(table.evaluate(r) / dipole->evaluate(r), 1, 4e-3) << r;
  for (const ProfileSample& s : table.samples()) EXPECT_NEAR(table.evaluate(s.r) / s.value, 1, 1e-13);
  EXPECT_NEAR(table.total() / dipole->total(), 1, 1e-3);
  EXPECT_EQ(table.evaluate(0), table.samples().front().value);
}

TEST(TabulatedProfile, IsMonotoneWhereTheDataAre) {
  // Steps and plateaus that make an ordinary cubic overshoot.
  const TabulatedProfile table({{.1, 5}, {.2, 4.99}, {.4, 1}, {.8, .999}, {1.6, .998}, {3.2, 1e-4}});
  double before = table.evaluate(0);
  for (double r = .01; r < 50; r *= 1.01) {
    EXPECT_LE(table.evaluate(r), before * (1 + 1e-14)) << r;
    before = table.evaluate(r);
  }
}

TEST(TabulatedProfile, HasAContinuousSlope) {
  const TabulatedProfile table({{.1, 5}, {.3, 4}, {1, .5}, {2, .4}, {5, 1e-3}});
  for (const ProfileSample& s : table.samples()) {
    const auto slope = [&](double r) { return (table.evaluate(r * (1 + 1e-7)) - table.evaluate(r)) / (r * 1e-7); };
    EXPECT_NEAR(slope(s.r), slope(s.r * (1 - 1e-7)), 1e-4 * s.value / s.r) << s.r;
  }
}

TEST(TabulatedProfile, CumulativeIsTheIntegralAndSampleItsInverse) {
  const TabulatedProfile table({{.1, 5}, {.3, 4}, {1, .5}, {2, .4}, {5, 1e-3}});
  double integral = 0, next = .05;
  for (double r = .00005; r < 30; r += .0001) {
    if (r > next) {
      EXPECT_NEAR(table.cumulative(r) / integral, 1, 1e-2) << r;
      next *= 2;
    }
    integral += .0001 * 2 * pi * r * table.evaluate(r);
  }
  EXPECT_NEAR(integral / table.total(), 1, 1e-6);
  EXPECT_NEAR(table.cumulative(1e6), table.total(), 1e-12);
  for (const double xi : {1e-6, .01, .2, .5, .9, .9999}) {
    EXPECT_NEAR(table.cumulative(table.sample(xi)) / table.total(), xi, 1e-12) << xi;
  }
}

TEST(TabulatedProfile, ReadsCsv) {
  const auto samples = parse_profile_csv("# measured\nr_mm,R_per_mm2\n0.1, 5.5e-1\r\n\n0.2,0.25\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].r, .1);
  EXPECT_EQ(samples[0].value, .55);
  EXPECT_EQ(samples[1].value, .25);
}

int bad_line(std::string_view text) {
  try {
    parse_profile_csv(text);
  } catch (const ProfileTableError& e) {
    return e.line;
  }
  return -1;
}

int bad_sample(std::vector<ProfileSample> samples) {
  try {
    const TabulatedProfile profile(std::move(samples));
  } catch (const ProfileTableError& e) {
    return e.line;
  }
  return -1;
}

TEST(TabulatedProfile, NamesTheLineThatIsWrong) {
  EXPECT_EQ(bad_line("1,2\n2;1\n"), 2);
  EXPECT_EQ(bad_line("r,R\n1,2\nx,1\n"), 3);
  EXPECT_EQ(bad_line("1,2\n2,1mm\n"), 2);
  EXPECT_EQ(bad_sample({{1, 2}}), 0);
  EXPECT_EQ(bad_sample({{1, 2}, {1, 1}}), 2);
  EXPECT_EQ(bad_sample({{1, 2}, {2, 0}}), 2);
  EXPECT_EQ(bad_sample({{0, 2}, {2, 1}}), 1);
  EXPECT_EQ(bad_sample({{1, 2}, {2, 3}}), 2);
  EXPECT_EQ(bad_sample({{1, 2}, {2, 1}}), -1);
}

}  // namespace
}  // namespace opaline
