#include "model/profiles/cumulative_table.h"

#include "model/profiles/better_dipole.h"

#include <gtest/gtest.h>

namespace opaline {
namespace {

TEST(CumulativeTable, EqualsTheClosedCumulative) {
  for (const double sigma_a : {.6, .01, 0.0}) {
    const BetterDipole<double> dipole(Medium<double>{sigma_a, 2, 1.3});
    const CumulativeTable table([&](double r) { return dipole.evaluate(r); }, dipole.core_radius());
    EXPECT_NEAR(table.total() / dipole.total(), 1, 1e-10);
    for (double r = 1e-7; r < 1e7; r *= 1.9) {
      EXPECT_NEAR(table.cumulative(r) / dipole.cumulative(r), 1, 1e-10) << sigma_a << " " << r;
    }
  }
}

TEST(CumulativeTable, SampleInvertsIt) {
  const BetterDipole<double> dipole(Medium<double>{.1, 2, 1.3});
  const CumulativeTable table([&](double r) { return dipole.evaluate(r); }, dipole.core_radius());
  for (const double xi : {1e-12, 1e-6, .001, .1, .5, .9, .99999}) {
    EXPECT_NEAR(table.sample(xi) / dipole.sample(xi), 1, 1e-6) << xi;
    EXPECT_NEAR(table.cumulative(table.sample(xi)) / table.total(), xi, 1e-13 * xi + 1e-15) << xi;
  }
  EXPECT_EQ(table.sample(0), 0);
}

TEST(CumulativeTable, NothingComesFromNothing) {
  const CumulativeTable table([](double) { return 0.0; }, 1.0);
  EXPECT_EQ(table.total(), 0);
  EXPECT_EQ(table.cumulative(2), 0);
  EXPECT_EQ(table.sample(.5), 0);
}

}  // namespace
}  // namespace opaline
