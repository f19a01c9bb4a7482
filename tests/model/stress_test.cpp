// The instrument itself: it must catch what is unstable, and pass what isn't.
#include "model/stress/stress.h"

#include "model/fresnel.h"
#include "model/profiles/better_dipole.h"
#include "model/profiles/normalised_diffusion.h"
#include "model/profiles/poles.h"
#include "model/profiles/profile.h"
#include "model/stress/function.h"
#include "model/stress/reference.h"

#include <gtest/gtest.h>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

using Independent = boost::multiprecision::cpp_bin_float_100;

constexpr double infinity = std::numeric_limits<double>::infinity();

Domain one_axis(double low, double high) { return {.axes = {{"x", {low, high}, low, high}}}; }

StressOptions quick() { return {.count = 2000, .points = 200, .seed = 3, .threads = 1, .only = ""}; }

StressResult stressed(const StressFunction& row) { return run_stress({row}, quick()).front(); }

/// A row without reference, whose values are only checked.
StressFunction checked(Domain domain, std::function<double(const double*)> value) {
  StressFunction row;
  row.name = "checked";
  row.domain = std::move(domain);
  row.value = std::move(value);
  return row;
}

StressFunction find_row(const std::string& name) {
  const auto rows = stress_functions();
  const auto row = std::ranges::find(rows, name, &StressFunction::name);
  EXPECT_NE(row, rows.end()) << name;
  return *row;
}

TEST(Stress, EveryRegisteredFunctionKeepsItsLimit) {
  StressOptions options;
  options.count = 1000;
  options.points = 16;
  for (const StressResult& r : run_stress(options)) {
    EXPECT_TRUE(r.passed()) << (r.derivative ? "derivatives of " : "") << r.name << " " << r.scaled.value << " of "
                            << r.limit << ", invalid " << r.invalid();
    EXPECT_GT(r.checked, 0u) << r.name;
    // Something is compared: of a thick slab's transmittance, where corners are mostly dark, not much.
    EXPECT_LE(r.dark, r.points * 4 / 5) << r.name;
  }
}

TEST(Stress, CoversTheFormulasAndTheRegistry) {
  const auto names = stress_function_names();
  for (const char* name : {"fresnel_reflectance", "diffuse_reflectance_internal", "dipole_boundary_a", "sample_pole",
                           "standard_dipole.evaluate", "better_dipole.total", "multipole.transmittance",
                           "layered.reflected", "single_scattering.profile", "layered_single_scattering_brdf"}) {
    EXPECT_NE(std::ranges::find(names, name), names.end()) << name;
  }
  for (const ProfileInfo& info : profiles()) {
    for (const char* what : {"", ".cumulative", ".sample"}) {
      EXPECT_NE(std::ranges::find(names, "profile " + info.name + what), names.end()) << info.name << what;
    }
  }
  auto sorted = names;
  std::ranges::sort(sorted);
  EXPECT_EQ(std::ranges::adjacent_find(sorted), sorted.end());
}

TEST(Stress, CatchesCancellationAndPassesTheStableForm) {
  const StressFunction naive = stress_function("1 - cos", one_axis(1e-8, 1), tight_limit, [](const auto* x) {
    using std::cos;
    return 1.0 - cos(x[0]);
  });
  const StressFunction stable = stress_function("2 sin^2", one_axis(1e-8, 1), tight_limit, [](const auto* x) {
    using std::sin;
    const auto half = sin(0.5 * x[0]);
    return 2.0 * half * half;
  });
  EXPECT_FALSE(stressed(naive).passed());
  EXPECT_GT(stressed(naive).scaled.value, 1e10);
  EXPECT_TRUE(stressed(stable).passed());
  EXPECT_LT(stressed(stable).plain.value, 4);
}

TEST(Stress, CatchesThePrintedCumulativeOfAPole) {
  const auto printed = [](const auto* x) {
    using std::exp;
    using std::sqrt;
    const auto d = sqrt(x[0] * x[0] + x[1] * x[1]);
    return exp(-x[2] * x[1]) - x[1] / d * exp(-x[2] * d);
  };
  const Domain domain{.axes = {{"r", {1}, 1e-6, 1}, {"z", {1}, .5, 2}, {"sigma", {1}, .1, 1}}};
  EXPECT_FALSE(stressed(stress_function("printed", domain, tight_limit, printed)).passed());
}

TEST(Stress, ForgivesWhatTheInputsCost) {
  // log(x^2) near 1 loses what rounding x^2 costs, and that is the function's condition, 2/log(x^2).
  const auto row = stress_function("log", one_axis(1 + 1e-9, 2), tight_limit, [](const auto* x) {
    using std::log;
    return log(x[0] * x[0]);
  });
  const StressResult r = stressed(row);
  EXPECT_TRUE(r.passed()) << r.scaled.value;
  EXPECT_GT(r.plain.value, 1000);
}

TEST(Stress, CountsEachKindOfInvalidValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Domain unit = one_axis(0.01, 1);
  const auto is_low = [](const double* x) { return x[0] < 0.1; };
  EXPECT_GT(stressed(checked(unit, [=](const double* x) { return is_low(x) ? nan : 1.0; })).nan, 0u);
  EXPECT_GT(stressed(checked(unit, [=](const double* x) { return is_low(x) ? infinity : 1.0; })).infinite, 0u);
  EXPECT_GT(stressed(checked(unit, [=](const double* x) { return is_low(x) ? -1e-300 : 1.0; })).negative, 0u);
  const auto bump = [](const double* x) { return 1 + std::abs(x[0] - 0.1); };
  const StressResult wrong = stressed(with_monotone(checked(unit, bump), {0, true}));
  EXPECT_GT(wrong.not_monotone, 0u);
  EXPECT_FALSE(wrong.passed());
  ASSERT_EQ(wrong.invalid_at.size(), 1u);
  EXPECT_LT(wrong.invalid_at[0], 0.1);
  EXPECT_EQ(stressed(checked(unit, bump)).invalid(), 0u);
}

TEST(Stress, CountsFloatsInTheirOwnUnits) {
  StressFunction row = stress_function("cube", one_axis(0.1, 10), 2, [](const auto* x) { return x[0] * x[0] * x[0]; });
  row.value = [](const double* x) { return static_cast<double>(static_cast<float>(x[0] * x[0] * x[0])); };
  EXPECT_FALSE(stressed(row).passed());
  row.unit = 0x1p29;
  EXPECT_TRUE(stressed(row).passed());
  EXPECT_LE(stressed(row).plain.value, 0.501);
  EXPECT_GT(stressed(row).plain.value, 0.4);
}

TEST(Stress, MonotoneFromOneLooksBothWays) {
  const auto valley = [](const double* x) { return std::abs(std::log(x[0])); };
  const Domain domain = one_axis(0.25, 4);
  EXPECT_EQ(stressed(with_monotone(checked(domain, valley), {0, true, true})).not_monotone, 0u);
  EXPECT_GT(stressed(with_monotone(checked(domain, valley), {0, true, false})).not_monotone, 0u);
  EXPECT_GT(stressed(with_monotone(checked(domain, valley), {0, false, true})).not_monotone, 0u);
}

TEST(Stress, CatchesAWrongDerivative) {
  const auto cube = [](const auto* x) { return x[0] * x[0] * x[0]; };
  StressFunction row = differentiated<1>("cube", one_axis(0.1, 10), tight_limit, cube);
  const auto derivatives = [&] { return run_stress({row}, quick()).back(); };
  EXPECT_TRUE(derivatives().passed());
  EXPECT_LT(derivatives().plain.value, 4);
  row.gradient = [](const double* x, double* g) { g[0] = 3 * x[0] * x[0] * (1 + 1e-11); };
  EXPECT_FALSE(derivatives().passed());
  EXPECT_TRUE(derivatives().derivative);
}

TEST(Stress, SameSeedSameResultForAnyNumberOfThreads) {
  StressOptions one = quick(), three = quick(), other = quick();
  one.only = three.only = other.only = "diffuse_";
  three.threads = 3;
  other.seed = 4;
  const auto a = run_stress(one), b = run_stress(three), c = run_stress(other);
  ASSERT_EQ(a.size(), b.size());
  bool differs = false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].plain.value, b[i].plain.value);
    EXPECT_EQ(a[i].plain.at, b[i].plain.at);
    differs = differs || a[i].plain.value != c[i].plain.value;
  }
  EXPECT_TRUE(differs);
}

TEST(StressReference, ConditionIsTheClosedForm) {
  const auto power = differentiated<2>("x^3/y", {.axes = {{"x", {}, 1, 2}, {"y", {}, 1, 2}}}, tight_limit,
                                       [](const auto* x) { return x[0] * x[0] * x[0] / x[1]; });
  EXPECT_NEAR(exact_value(power, {1.7, 2.5}).condition, 4, 1e-12);
  const Exact slope = exact_derivative(power, {1.7, 2.5}, 0);
  EXPECT_NEAR(static_cast<double>(slope.value), 3 * 1.7 * 1.7 / 2.5, 1e-14);
  EXPECT_NEAR(slope.condition, 3, 1e-12);
}

TEST(StressReference, FlatPointsAndKinksHaveTheStatedDerivative) {
  const StressFunction moment = find_row("second_moment_internal"), average = find_row("diffuse_reflectance_internal");
  EXPECT_EQ(exact_derivative(moment, {1}, 0).value, 0);
  EXPECT_NEAR(static_cast<double>(exact_derivative(average, {1}, 0).value), 7.0 / 3, 1e-15);
}

TEST(StressReference, CountsUnitsInTheLastPlace) {
  const Exact one{1, 1, 0}, none{0, 0, 0};
  EXPECT_EQ(ulp_error(1 + 0x1p-52, one), 1);
  EXPECT_EQ(ulp_error(1 - 0x1p-53, one), 0.5);
  EXPECT_EQ(ulp_error(0, none), 0);
  EXPECT_EQ(ulp_error(1e-300, none), infinity);
}

TEST(StressReference, DiffuseReflectanceIsTheSeriesInAnotherArithmetic) {
  for (const double eta : {.3, .7, 1 - 1e-9, 1.0, 1 + 0x1p-52, 1 + 1e-9, 1.001, 1.0025, 1.5, 3.5}) {
    const Wide value = diffuse_reflectance_internal(Wide(eta));
    const Independent series = diffuse_reflectance_internal(Independent(eta));
    const Independent difference = abs(Independent(Independent(value.str()) - series));
    EXPECT_LE(difference, Independent("1e-75") * series) << eta;
    const Independent moment = second_moment_internal(Independent(eta));
    const Independent off = abs(Independent(Independent(second_moment_internal(Wide(eta)).str()) - moment));
    EXPECT_LE(off, Independent("1e-90") * moment) << eta;
  }
}

TEST(StressReference, SamplersInvertTheirCumulatives) {
  const StressFunction pole = find_row("sample_pole"), better = find_row("better_dipole.sample"),
                       normalised = find_row("normalised_diffusion.sample");
  for (const double sigma : {0.0, .3, 40.0}) {
    for (const double xi : {1e-12, .3, 1 - 0x1p-53}) {
      const Wide x[] = {.5, sigma, xi}, r = pole.reference(x);
      const Wide left = exp(Wide(-x[1] * x[0])) - pole_cumulative(r, x[0], x[1]);
      EXPECT_LT(abs(Wide(left / (exp(Wide(-x[1] * x[0])) * (1 - x[2])) - 1)), 1e-35) << sigma << " " << xi;
      const Wide y[] = {sigma, 1, 1.3, xi};
      const BetterDipole<Wide> dipole(medium_of(y));
      EXPECT_LT(abs(Wide(dipole.cumulative(better.reference(y)) / dipole.total() - y[3])), 1e-50 * xi);
    }
  }
  for (const double xi : {.1, .7, .99}) {
    const Wide y[] = {.2, 1, 1.3, xi}, r = normalised.reference(y);
    using Diffusion = SearchlightNormalisedDiffusion<Wide>;
    const Diffusion shape(medium_of(y));
    const Wide rho = sqrt(Wide(r * r + shape.c * shape.c));
    EXPECT_LT(abs(Wide(Diffusion::beyond(Wide(rho / shape.d)) - (1 - y[3]))), 1e-50);
  }
}

TEST(StressDomain, CornersAreEveryCombinationAndPointsStayInside) {
  const Domain domain{.axes = {{"a", {1, 2, 3}, 1, 3},
                               {"b", {0, 1 - 0x1p-53}, 1e-20, 1, Spread::share},
                               {"c", {}, .3, 3.5, Spread::around_one}}};
  Domain two = domain;
  two.axes.pop_back();
  EXPECT_EQ(corner_points(two).size(), 6u);
  SplitMix random{9};
  Input point{};
  double nearest = 1;
  for (int i = 0; i < 20000; ++i) {
    point = random_point(domain, random, point, false);
    EXPECT_TRUE(point[0] >= 1 && point[0] <= 3 && point[1] >= 0 && point[1] < 1 && point[2] >= .3 && point[2] <= 3.5);
    nearest = std::min(nearest, 1 - point[1]);
  }
  EXPECT_LE(nearest, 0x1p-52);
}

TEST(StressDomain, MediaHaveTheStatedAlbedoAndRadius) {
  const Domain domain = find_row("standard_dipole.evaluate").domain;
  const Input x = domain.inputs_at({4, 0.25, 1.3, 8});
  EXPECT_DOUBLE_EQ(x[0], 1);
  EXPECT_DOUBLE_EQ(x[1], 3);
  EXPECT_EQ(x[2], 1.3);
  EXPECT_DOUBLE_EQ(x[3], 2);
  EXPECT_EQ(domain.inputs_at({1, 1e-12, 1, 0})[0], 1e-12);
  EXPECT_EQ(domain.input_name(0), "sigma_a");
}

}  // namespace
}  // namespace opaline
