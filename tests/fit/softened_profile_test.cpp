#include "fit/softened_profile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

/// 2 pi int R r dr by the trapezoid rule in log r.
template <typename F>
double flux(const F& profile) {
  double sum = 0;
  for (double t = -22; t < 6; t += .05) {
    const double r = std::exp(t);
    sum += .05 * 2 * pi * r * r * profile(r);
  }
  return sum;
}

TEST(SoftenedProfile, KeepsTheFluxAndItsDerivatives) {
  const ProfileInfo& info = *find_profile("transport_table");
  const Medium<double> m{.1, 1, 1.3};
  const auto profile = info.make(m);
  const SoftenedProfile soft(*profile, .02);
  EXPECT_NEAR(flux([&](double r) { return soft.evaluate_with_gradient(r).value; }), profile->total(), 1e-6);
  EXPECT_LT(soft.evaluate_with_gradient(0).value, .1 * profile->evaluate(0));
  const auto total = [&](double a, double s, double e) { return info.make({a, s, e})->total(); };
  const double h = 1e-4;
  EXPECT_NEAR(flux([&](double r) { return soft.evaluate_with_gradient(r).d_sigma_a; }),
              (total(.1 + h, 1, 1.3) - total(.1 - h, 1, 1.3)) / (2 * h), 1e-5);
  EXPECT_NEAR(flux([&](double r) { return soft.evaluate_with_gradient(r).d_sigma_s_prime; }),
              (total(.1, 1 + h, 1.3) - total(.1, 1 - h, 1.3)) / (2 * h), 1e-5);
  EXPECT_NEAR(flux([&](double r) { return soft.evaluate_with_gradient(r).d_eta; }),
              (total(.1, 1, 1.3 + h) - total(.1, 1, 1.3 - h)) / (2 * h), 1e-5);
}

TEST(SoftenedProfile, IsTheProfileFarOutAndWhereTheCoreIsWide) {
  for (const std::string& name : medium_profile_names()) {
    const ProfileInfo& info = *find_profile(name);
    const auto profile = info.make({.1, 1, 1.3});
    const double core = profile->core_radius();
    const SoftenedProfile same(*profile, .9 * core), soft(*profile, 3 * core);
    for (const double r : {0.0, core, 40 * core}) {
      EXPECT_EQ(same.evaluate_with_gradient(r).value, profile->evaluate_with_gradient(r).value) << info.name;
    }
    const double far = 60 * core, exact = profile->evaluate(far);
    EXPECT_NEAR(soft.evaluate_with_gradient(far).value, exact, 5e-3 * exact + 1e-7 * profile->evaluate(3 * core))
        << info.name;
  }
}

}  // namespace
}  // namespace opaline
