// What a fit says about its own errors, against the errors it makes and against the Cramer-Rao bound.
#include "fit/uncertainty.h"
#include "tests/support/fit_fixture.h"

#include <gmock/gmock.h>
#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace opaline {
namespace {

using test::dipole;

std::vector<FitTarget> one_target(TransportOperator op, const Image& picture) {
  std::vector<FitTarget> targets;
  targets.push_back(make_target(std::move(op), picture, "target.exr"));
  return targets;
}

/// Standard deviation of the solver's parameter.
double solver_sd(const Uncertainty& u, int i) { return std::sqrt(u.covariance(i, i)); }

TEST(Noise, ErrorsAreWhatTheIntervalsSay) {
  const Scene scene = test::sphere_scene("skin1", 20);
  SolveSettings settings;
  settings.bounds.eta_min = 1.15, settings.bounds.eta_max = 1.6;
  settings.starts = 1;  // the optimum is near; other tests look for it
  const EtaNodes etas(1.15, 1.6, 4);
  const TransportOperator op = build_operator(scene, 0, etas, test::small_operator(2000));
  const ParameterVector truth = to_parameters(scene.materials[0], {});
  const Image clean = operator_image(op, dipole(), scene.materials[0]);
  constexpr int seeds = 40;
  int covered = 0;
  double distance = 0, square[parameter_count] = {};
  for (int seed = 1; seed <= seeds; ++seed) {
    Image picture = clean;
    add_noise(picture, 0.01, static_cast<std::uint64_t>(seed));
    const Solution s = solve(one_target(op, picture), dipole(), scene.materials[0], settings);
    const Uncertainty u = uncertainty(s, settings.free);
    Eigen::VectorXd error(parameter_count);
    for (int i = 0; i < parameter_count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      error[i] = s.parameters[at] - truth[at];
      const double z = error[i] / solver_sd(u, i);
      EXPECT_LT(std::abs(z), 4) << "seed " << seed << " " << parameter_name(i);
      square[i] += z * z / seeds;
      const double value = natural_value(i, truth[at]);
      covered += u.parameters[at].low <= value && value <= u.parameters[at].high;
    }
    distance += error.dot(u.covariance.ldlt().solve(error)) / (seeds * parameter_count);
  }
  // Mean of n squared standard normals: sd sqrt(2 / n).
  for (int i = 0; i < parameter_count; ++i) EXPECT_NEAR(square[i], 1, 4 * std::sqrt(2.0 / seeds)) << parameter_name(i);
  EXPECT_NEAR(distance, 1, 4 * std::sqrt(2.0 / (seeds * parameter_count)));
  // 95 % of 280 are 266; they come in correlated sevens.
  EXPECT_GE(covered, 248);
  EXPECT_LE(covered, 278);
}

/// Derivative of every pixel and channel in the solver's parameter i, by two renders of the reference.
Eigen::VectorXd picture_derivative(const Scene& scene, const OperatorSettings& settings, const ParameterVector& at,
                                   std::size_t i, double step) {
  Eigen::VectorXd values[2];
  for (int side = 0; side < 2; ++side) {
    Scene moved = scene;
    ParameterVector p = at;
    p[i] += side ? step : -step;
    moved.materials[0] = to_material(p, scene.materials[0]);
    const Image image = test::picture_of(moved, settings, "hierarchical",
                                         {{"max_relative_error", "1e-5"}, {"discretisation", "fixed"}});
    values[side] = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(3 * image.pixel_count()));
    for (std::size_t k = 0; k < image.pixel_count(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        values[side][static_cast<Eigen::Index>(3 * k + c)] = static_cast<double>(image.data[4 * k + c]);
  }
  return (values[1] - values[0]) / (2 * step);
}

TEST(Noise, IntervalsAttainTheCramerRaoBound) {
  const Scene scene = test::sphere_scene("skin1", 16, 1000);
  const OperatorSettings settings = test::small_operator(1000);
  Image picture =
      test::picture_of(scene, settings, "hierarchical", {{"max_relative_error", "1e-5"}, {"discretisation", "fixed"}});
  const std::array<double, 3> sd = add_noise(picture, 0.01, 1);
  const ParameterVector truth = to_parameters(scene.materials[0], {});
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(3 * picture.pixel_count()), parameter_count);
  for (std::size_t i = 0; i < parameter_count; ++i) {
    const double step = i == eta_index ? 0.01 : 0.03;
    Eigen::VectorXd derivative = picture_derivative(scene, settings, truth, i, step);
    const Eigen::VectorXd wider = picture_derivative(scene, settings, truth, i, 2 * step);
    // Truncation grows fourfold with the step, the renderer's error falls to half: both are below 1 %.
    EXPECT_LT((derivative - wider).norm(), 0.01 * derivative.norm()) << parameter_name(static_cast<int>(i));
    for (Eigen::Index row = 0; row < derivative.size(); ++row) derivative[row] /= sd[static_cast<std::size_t>(row % 3)];
    jacobian.col(static_cast<Eigen::Index>(i)) = derivative;
  }
  const Eigen::MatrixXd bound = (jacobian.transpose() * jacobian).inverse();
  const Solution s = solve(one_target(build_operator(scene, 0, test::free_eta(), settings), picture), dipole(),
                           test::neutral_material(), {});
  const Uncertainty u = uncertainty(s, {});
  for (int i = 0; i < parameter_count; ++i) {
    EXPECT_NEAR(solver_sd(u, i) / std::sqrt(bound(i, i)), 1, 0.2) << parameter_name(i);
    EXPECT_LT(std::abs(s.parameters[static_cast<std::size_t>(i)] - truth[static_cast<std::size_t>(i)]),
              4 * solver_sd(u, i))
        << parameter_name(i);
    for (int j = 0; j < i; ++j)
      EXPECT_NEAR(u.correlation(i, j), bound(i, j) / std::sqrt(bound(i, i) * bound(j, j)), 0.1);
  }
}

TEST(Noise, TwoPicturesTightenTheIntervals) {
  Scene scene = test::sphere_scene("marble", 20);
  std::vector<FitTarget> both, first;
  const DirectionalLight lights[2] = {{glm::normalize(glm::dvec3(0.8, -0.3, -0.5)), Rgb(1), 0},
                                      {glm::normalize(glm::dvec3(-0.9, 0.4, -0.1)), Rgb(3, 2, 1), 0}};
  for (int i = 0; i < 2; ++i) {
    scene.lights = {lights[i]};
    TransportOperator op = build_operator(scene, 0, test::free_eta(), test::small_operator(1500));
    Image picture = operator_image(op, dipole(), scene.materials[0]);
    add_noise(picture, 0.01, static_cast<std::uint64_t>(i + 1));
    both.push_back(make_target(std::move(op), picture, "target.exr"));
    if (i == 0) first = both;
  }
  const Solution one = solve(first, dipole(), scene.materials[0], {}),
                 two = solve(both, dipole(), scene.materials[0], {});
  EXPECT_EQ(two.noise_sd.size(), 2u);
  EXPECT_NEAR(two.noise_sd[1][0] / two.noise_sd[1][2] / (one.noise_sd[0][0] / one.noise_sd[0][2]), 3, 0.5);
  const Uncertainty a = uncertainty(one, {}), b = uncertainty(two, {});
  const ParameterVector truth = to_parameters(scene.materials[0], {});
  for (int i = 0; i < parameter_count; ++i) {
    EXPECT_LT(solver_sd(b, i), 0.85 * solver_sd(a, i)) << parameter_name(i);
    EXPECT_LT(std::abs(two.parameters[static_cast<std::size_t>(i)] - truth[static_cast<std::size_t>(i)]),
              4 * solver_sd(b, i));
  }
}

TEST(Noise, CorrelationsAreReported) {
  const Scene scene = test::sphere_scene("skin1", 16);
  const TransportOperator op = build_operator(scene, 0, test::free_eta(), test::small_operator(1500));
  Image picture = operator_image(op, dipole(), scene.materials[0]);
  add_noise(picture, 0.01, 1);
  const Uncertainty u = uncertainty(solve(one_target(op, picture), dipole(), scene.materials[0], {}), {});
  ASSERT_EQ(u.correlation.rows(), parameter_count);
  std::size_t strong = 0;
  for (int i = 0; i < parameter_count; ++i) {
    EXPECT_EQ(u.correlation(i, i), 1);
    for (int j = 0; j < i; ++j) {
      EXPECT_NEAR(u.correlation(i, j), u.correlation(j, i), 1e-12);
      EXPECT_LE(std::abs(u.correlation(i, j)), 1);
      strong += std::abs(u.correlation(i, j)) > 0.9;
    }
  }
  EXPECT_GT(strong, 0u);
  std::size_t named = 0;
  for (const std::string& note : u.notes) named += note.find("trade off") != std::string::npos;
  EXPECT_EQ(named, strong);
}

/// A slab so wide and evenly lit that every point looks alike: only the total reflectance shows.
Scene flat_scene() {
  Scene scene = test::make_scene(make_slab({100, 100, 30}, 3000), test::library_material("cream"), 20, 24);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  return scene;
}

/// What a fit of the flat picture may say and what it may not.
void expect_albedo_only(const Solution& s, const Material& material, const FreeParameters& free) {
  const Uncertainty u = uncertainty(s, free);
  const ParameterVector truth = to_parameters(material, {});
  for (std::size_t i = 0; i < eta_index; ++i) {
    EXPECT_FALSE(u.parameters[i].identifiable) << parameter_name(static_cast<int>(i));
    EXPECT_FALSE(u.parameters[i].reason.empty());
    EXPECT_LT(u.parameters[i].low, natural_value(static_cast<int>(i), truth[i]));
    EXPECT_GT(u.parameters[i].high, natural_value(static_cast<int>(i), truth[i]));
  }
  for (int c = 0; c < 3; ++c) {
    const ParameterEstimate& alpha = u.alpha_prime[static_cast<std::size_t>(c)];
    const double expected = material.sigma_s_prime[c] / (material.sigma_a[c] + material.sigma_s_prime[c]);
    EXPECT_TRUE(alpha.identifiable) << "channel " << c << " " << alpha.value << " sd " << alpha.sd;
    EXPECT_NEAR(alpha.value, expected, 0.5 * std::max(1 - expected, 0.02));
  }
  EXPECT_TRUE(u.parameters[eta_index].identifiable);
  EXPECT_FALSE(u.parameters[eta_index].free);
  EXPECT_THAT(u.notes, ::testing::Contains(::testing::HasSubstr("determines the albedo alpha'")));
}

TEST(Noise, AFlatPictureDeterminesTheAlbedoOnly) {
  const Scene scene = flat_scene();
  const Material& material = scene.materials[0];
  const TransportOperator op = build_operator(scene, 0, EtaNodes(material.eta), test::small_operator(6000));
  const Image clean = operator_image(op, dipole(), material);
  SolveSettings settings;
  settings.free.eta = false;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    Image picture = clean;
    add_noise(picture, 0.01, seed);
    const Solution s = solve(one_target(op, picture), dipole(), test::library_material("skin2"), settings);
    expect_albedo_only(s, material, settings.free);
  }
}

}  // namespace
}  // namespace opaline
