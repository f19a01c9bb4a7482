// The fit finds what a picture was made of: from its own pictures, from the reference's, from anywhere.
#include "fit/solve.h"

#include "fit/reduced_picture.h"
#include "tests/support/fit_fixture.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

namespace opaline {
namespace {

using test::dipole;

struct Sphere {
  Scene scene;
  OperatorSettings settings = test::small_operator(2000);
  TransportOperator op;
  ParameterVector truth;

  explicit Sphere(const std::string& material, int pixels = 28, const EtaNodes& etas = test::free_eta())
      : scene(test::sphere_scene(material, pixels)),
        op(build_operator(scene, 0, etas, settings)),
        truth(to_parameters(scene.materials[0], {})) {}
  Image picture() const { return operator_image(op, dipole(), scene.materials[0]); }
  std::vector<FitTarget> target(const Image& image) const {
    std::vector<FitTarget> targets;
    targets.push_back(make_target(op, image, "target.exr"));
    return targets;
  }
};

TEST(Solve, RecoversAllSevenParametersFromTheOperatorsPicture) {
  const Sphere sphere("skin1", 48);
  const Solution s = solve(sphere.target(sphere.picture()), dipole(), test::neutral_material(), {});
  for (int i = 0; i < parameter_count; ++i)
    EXPECT_NEAR(test::relative_error(i, s.parameters, sphere.truth), 0, 1e-7) << parameter_name(i);
  EXPECT_TRUE(s.converged);
  EXPECT_LT(s.relative_rmse, 3e-7);
  ASSERT_EQ(s.starts.size(), 8u);
  for (int i = 0; i < parameter_count; ++i)
    EXPECT_EQ(s.starts[0].from[static_cast<std::size_t>(i)],
              to_parameters(test::neutral_material(), {})[static_cast<std::size_t>(i)]);
  int iterations = 0;
  for (const StartRecord& start : s.starts) {
    EXPECT_GE(start.cost, s.starts[static_cast<std::size_t>(s.best_start)].cost);
    EXPECT_LE(start.history.back(), start.history.front());
    iterations += static_cast<int>(start.history.size());
  }
  EXPECT_GT(s.iterations, iterations);  // and the polishing run
}

TEST(Solve, RecoversTheReferencesPicture) {
  const Sphere sphere("marble");
  const Image picture = test::picture_of(sphere.scene, sphere.settings, "hierarchical",
                                         {{"max_relative_error", "1e-4"}, {"discretisation", "fixed"}});
  const Solution s = solve(sphere.target(picture), dipole(), test::neutral_material(), {});
  for (int i = 0; i < parameter_count; ++i)
    EXPECT_NEAR(test::relative_error(i, s.parameters, sphere.truth), 0, 1e-3) << parameter_name(i);
  EXPECT_LT(s.relative_rmse, 1e-4);
}

TEST(Solve, FindsTheOptimumFromAWildFirstStart) {
  const Sphere sphere("skin1", 24);
  Material wild;
  wild.sigma_a = {900, 1e-5, 40};
  wild.sigma_s_prime = {0.002, 2000, 1e-4};
  wild.eta = 1.95;
  Image picture = sphere.picture();
  add_noise(picture, 0.01, 3);
  const std::vector<FitTarget> targets = sphere.target(picture);
  const Solution from_wild = solve(targets, dipole(), wild, {}),
                 from_near = solve(targets, dipole(), sphere.scene.materials[0], {});
  EXPECT_NE(from_wild.best_start, 0);
  for (int i = 0; i < parameter_count; ++i)
    EXPECT_NEAR(test::relative_error(i, from_wild.parameters, from_near.parameters), 0, 1e-6) << parameter_name(i);
  SolveSettings one;
  one.starts = 1;
  const Solution alone = solve(targets, dipole(), wild, one);
  EXPECT_EQ(alone.starts.size(), 1u);
  EXPECT_GT(alone.rmse, 1.5 * from_wild.rmse);  // the starts are needed
}

TEST(Solve, ResidualsAndNoiseAreThoseOfThePicture) {
  const Sphere sphere("skin1", 24, EtaNodes(1.3));
  Image picture = sphere.picture();
  const std::array<double, 3> sd = add_noise(picture, 0.02, 5);
  SolveSettings settings;
  settings.free.eta = false;
  const Solution s = solve(sphere.target(picture), dipole(), sphere.scene.materials[0], settings);
  const Image refit = operator_image(sphere.op, dipole(), to_material(s.parameters, sphere.scene.materials[0]));
  EXPECT_NEAR(s.relative_rmse, test::relative_rms(sphere.op, refit, picture), 1e-6);
  EXPECT_LT(s.relative_rmse, 1.05 * 0.02);
  double sum = 0;
  for (const std::uint32_t pixel : sphere.op.pixels)
    for (std::size_t c = 0; c < 3; ++c)
      sum += std::pow(static_cast<double>(refit.data[pixel * 4u + c] - picture.data[pixel * 4u + c]), 2);
  const double rows = static_cast<double>(sphere.op.rows());
  EXPECT_NEAR(s.rmse / std::sqrt(sum / (3 * rows)), 1, 1e-5);
  // Standard deviation of a standard deviation: 1 / sqrt(2 n).
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(s.noise_sd[0][c] / sd[c], 1, 4 / std::sqrt(2 * rows));
}

TEST(Solve, AStartsExcessIsHowMuchWorseItFits) {
  const Sphere sphere("skin1", 20);
  Image picture = sphere.picture();
  add_noise(picture, 0.01, 13);
  SolveSettings settings;
  settings.max_iterations = 5;  // not all starts arrive
  const Solution s = solve(sphere.target(picture), dipole(), test::neutral_material(), settings);
  const auto half_chi_squared = [&](const ParameterVector& p) {
    const Image refit = operator_image(sphere.op, dipole(), to_material(p, {}));
    double sum = 0;
    for (const std::uint32_t pixel : sphere.op.pixels)
      for (std::size_t c = 0; c < 3; ++c)
        sum += std::pow(
            static_cast<double>(refit.data[pixel * 4u + c] - picture.data[pixel * 4u + c]) / s.noise_sd[0][c], 2);
    return sum / 2;
  };
  const double least = half_chi_squared(s.parameters);
  double largest = 0;
  for (const StartRecord& start : s.starts) {
    const double expected = half_chi_squared(start.to) - least;
    EXPECT_NEAR(start.excess, expected, 1e-3 + 1e-5 * std::abs(expected));
    largest = std::max(largest, start.excess);
  }
  EXPECT_GT(largest, 10);
}

TEST(Solve, WhatIsNotFreeStaysExactly) {
  const Sphere sphere("skin1", 20);
  Image picture = sphere.picture();
  add_noise(picture, 0.01, 7);
  const std::vector<FitTarget> targets = sphere.target(picture);
  Material start = sphere.scene.materials[0];
  start.sigma_a *= 1.1, start.sigma_s_prime *= 0.9, start.eta = 1.37;
  const ParameterVector initial = to_parameters(start, {});
  for (const char* words : {"sigma_a", "sigma_s_prime", "eta", "sigma_a,eta", "sigma_a,sigma_s_prime"}) {
    SCOPED_TRACE(words);
    SolveSettings settings;
    settings.free = parse_free(words);
    settings.starts = 3;
    const Solution s = solve(targets, dipole(), start, settings);
    for (std::size_t i = 0; i < parameter_count; ++i) {
      const bool free = settings.free.is_free(static_cast<int>(i));
      EXPECT_EQ(s.parameters[i] == initial[i], !free) << parameter_name(static_cast<int>(i));
      EXPECT_EQ(s.jacobian.col(static_cast<Eigen::Index>(i)).norm() > 0, free);
      for (const StartRecord& record : s.starts) EXPECT_TRUE(free || record.from[i] == initial[i]);
    }
  }
}

TEST(Solve, TheJacobianIsTheDerivativeOfTheWhitenedPicture) {
  const Sphere sphere("marble", 20);
  Image picture = sphere.picture();
  add_noise(picture, 0.01, 9);
  const std::vector<FitTarget> targets = sphere.target(picture);
  SolveSettings settings;
  settings.free.sigma_a = false;  // the columns of the others keep their places
  const Solution s = solve(targets, dipole(), sphere.scene.materials[0], settings);
  const auto whitened_picture = [&](const ParameterVector& p) {
    const auto z = reduced_picture(targets[0], dipole(), to_material(p, {}), false);
    Eigen::VectorXd all = Eigen::VectorXd::Zero(s.jacobian.rows());
    for (int c = 0; c < 3; ++c) s.whitened[0].add(c, z[static_cast<std::size_t>(c)].value, all);
    return all;
  };
  for (std::size_t i = 3; i < parameter_count; ++i) {
    const double h = 1e-5;
    ParameterVector above = s.parameters, below = s.parameters;
    above[i] += h, below[i] -= h;
    const Eigen::VectorXd expected = (whitened_picture(above) - whitened_picture(below)) / (2 * h);
    EXPECT_LT((s.jacobian.col(static_cast<Eigen::Index>(i)) - expected).norm(), 1e-6 * expected.norm());
  }
  EXPECT_EQ(s.jacobian.leftCols(3).norm(), 0);
}

TEST(Solve, IsTheSameForAnyNumberOfThreads) {
  const Sphere sphere("skin1", 20);
  Image picture = sphere.picture();
  add_noise(picture, 0.01, 11);
  const auto run = [&](std::size_t threads) {
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
    return solve(sphere.target(picture), dipole(), test::neutral_material(), {});
  };
  const Solution one = run(1), two = run(2);
  EXPECT_EQ(one.parameters, two.parameters);
  EXPECT_EQ(one.noise_sd, two.noise_sd);
  EXPECT_TRUE(one.jacobian == two.jacobian);
  for (std::size_t i = 0; i < one.starts.size(); ++i) EXPECT_EQ(one.starts[i].history, two.starts[i].history);
}

TEST(Solve, EndsAtABoundAndSaysSo) {
  const Sphere sphere("marble", 20);
  SolveSettings settings;
  settings.bounds.sigma_max = 2;  // marble scatters more: 2.19, 2.62, 3.00
  settings.bounds.eta_min = 1.6;  // and bends less: 1.5
  const Solution s = solve(sphere.target(sphere.picture()), dipole(), test::neutral_material(), settings);
  const Uncertainty u = uncertainty(s, settings.free);
  for (std::size_t i = 3; i < parameter_count; ++i) {
    EXPECT_NEAR(u.parameters[i].value, i == eta_index ? 1.6 : 2, 1e-6);
    EXPECT_FALSE(u.parameters[i].identifiable);
    EXPECT_EQ(u.parameters[i].reason, "it ended at a bound of its range");
    EXPECT_GE(u.parameters[i].low, i == eta_index ? 1.6 : 1e-6);
    EXPECT_LE(u.parameters[i].high, i == eta_index ? 2.0 : 2.0 + 1e-12);
  }
}

TEST(Solve, OneIterationIsNotConvergence) {
  const Sphere sphere("skin1", 16);
  SolveSettings settings;
  settings.max_iterations = 1;
  settings.starts = 1;
  const Solution s = solve(sphere.target(sphere.picture()), dipole(), test::neutral_material(), settings);
  EXPECT_FALSE(s.converged);
  EXPECT_FALSE(s.starts[0].converged);
  EXPECT_FALSE(s.starts[0].message.empty());
}

}  // namespace
}  // namespace opaline
