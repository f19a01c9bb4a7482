// What a fit says of itself: models compared, likelihood profiles, repetitions, robust losses, priors, words, advice.
#include "fit/advise.h"
#include "fit/bootstrap.h"
#include "fit/compare_models.h"
#include "fit/diagnosis.h"
#include "fit/profile_interval.h"
#include "fit/residual_structure.h"
#include "tests/support/fit_fixture.h"

#include <gmock/gmock.h>
#include <Eigen/LU>

#include <random>

namespace opaline {
namespace {

using test::dipole;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// A sphere of skin with noise of 1 %, eta known: everything about it is determined.
struct Sphere {
  Scene scene = test::sphere_scene("skin1", 20);
  TransportOperator op = build_operator(scene, 0, EtaNodes(1.3), test::small_operator(1500));
  SolveSettings settings;
  std::vector<FitTarget> targets;

  explicit Sphere(const ProfileInfo& profile = dipole(), double noise = 0.01) {
    settings.free.eta = false;
    settings.starts = 1;
    Image picture = operator_image(op, profile, scene.materials[0]);
    add_noise(picture, noise, 1);
    targets.push_back(make_target(op, picture, "target"));
  }
  Solution solved(const ProfileInfo& profile = dipole()) const {
    return solve(targets, profile, scene.materials[0], settings);
  }
};

TEST(CompareModels, FindsTheModelAndWarnsOfTheOthers) {
  const ProfileInfo& transport = *find_profile("transport_table");
  const Sphere sphere(transport, 0.003);
  const Solution s = sphere.solved(transport);
  const Uncertainty u = uncertainty(s, sphere.settings.free);
  const ModelComparison c = compare_models(sphere.targets, "transport_table", s, u,
                                           to_material(s.parameters, sphere.scene.materials[0]), sphere.settings, 0);
  EXPECT_EQ(c.models.size() + c.left_out.size(), medium_profile_names().size());
  EXPECT_THAT(c.left_out, Contains(HasSubstr("directional_dipole: depends on the direction")));
  std::size_t fitted = 0;
  for (const ModelFit& m : c.models) {
    if (m.name == "multipole") {
      EXPECT_EQ(m.same_as, "standard_dipole");
    }
    if (!m.same_as.empty()) continue;
    ++fitted;
    EXPECT_GE(m.delta_bic, 0);
    if (m.name == "transport_table") {
      EXPECT_EQ(m.delta_bic, 0);
    }
    // Every model has the same number of parameters: the criterion is the likelihood's, n ln RSS for equal noise.
    EXPECT_GE(m.solution.relative_rmse, 0.99 * s.relative_rmse);
  }
  EXPECT_GE(fitted, 5u);
  EXPECT_THAT(c.warnings,
              Contains(AllOf(HasSubstr("disagrees with transport"), HasSubstr("small residual is not accuracy"))));
}

TEST(ProfileInterval, IsTheParabolaWhereThatHolds) {
  const Sphere sphere(dipole(), 0.001);
  const Solution s = sphere.solved();
  const Uncertainty parabola = uncertainty(s, sphere.settings.free);
  Uncertainty u = parabola;
  const FitProblem problem(sphere.targets, s.whitened, dipole(), sphere.settings, s.bounds);
  profile_intervals(problem, s, u);
  for (std::size_t i = 0; i < eta_index; ++i) {
    EXPECT_NEAR(u.parameters[i].low, parabola.parameters[i].low, 0.1 * parabola.parameters[i].sd);
    EXPECT_NEAR(u.parameters[i].high, parabola.parameters[i].high, 0.1 * parabola.parameters[i].sd);
  }
}

TEST(ProfileInterval, EndsWhereTheConstrainedFitIsWorseByTheThreshold) {
  const Sphere sphere(dipole(), 0.5);  // so noisy that the likelihood is no parabola
  const Solution s = sphere.solved();
  Uncertainty u = uncertainty(s, sphere.settings.free);
  const FitProblem problem(sphere.targets, s.whitened, dipole(), sphere.settings, s.bounds);
  profile_intervals(problem, s, u);
  const FitPoint best{s.parameters, s.ln_scale};
  int moved = 0;
  for (int i = 0; i < eta_index; ++i) {
    const ParameterEstimate& e = u.parameters[static_cast<std::size_t>(i)];
    if (e.interval != "profile") continue;
    for (const double end : {e.low, e.high}) {
      if (end < 2e-6 || end > 0.99 * s.bounds.sigma_max) continue;  // open
      FitPoint at = best;
      at.material[static_cast<std::size_t>(i)] = std::log(end);
      const double excess = problem.half_chi_squared(problem.minimise(at, i).at) - problem.half_chi_squared(best);
      EXPECT_NEAR(excess, 1.9207, 0.06) << parameter_name(i);
      ++moved;
    }
  }
  EXPECT_GT(moved, 2);
}

TEST(BootstrapTest, AgreesWithTheCovarianceAndIsReproducible) {
  const Sphere sphere;
  const Solution s = sphere.solved();
  const Uncertainty u = uncertainty(s, sphere.settings.free);
  const FitProblem problem(sphere.targets, s.whitened, dipole(), sphere.settings, s.bounds);
  const Bootstrap b = bootstrap(problem, s, 200, 3);
  EXPECT_EQ(b.failed, 0);
  ASSERT_EQ(b.draws.rows(), 200);
  for (int i = 0; i < eta_index; ++i) {
    const double sd = std::sqrt(u.covariance(i, i));
    EXPECT_NEAR(b.sd[i] / sd, 1, 4 / std::sqrt(2 * 200.0)) << parameter_name(i);
    EXPECT_LT(std::abs(b.bias[i]), 4 * sd / std::sqrt(200.0));
    EXPECT_LT(b.low[i], s.parameters[static_cast<std::size_t>(i)]);
    EXPECT_GT(b.high[i], s.parameters[static_cast<std::size_t>(i)]);
  }
  EXPECT_LT(b.sd[eta_index], 1e-12);
  EXPECT_TRUE(bootstrap(problem, s, 20, 3).draws == b.draws.topRows(20));
}

TEST(Robust, OutliersPullSquaresButNotTheOthers) {
  const Sphere clean;
  Sphere spoilt;
  Eigen::MatrixXd picture = spoilt.targets[0].picture;
  std::mt19937 random(5);
  for (Eigen::Index p = 0; p < picture.rows(); ++p)
    if (random() % 20 == 0) picture.row(p) *= 3;  // one pixel in twenty is a highlight
  replace_picture(spoilt.targets[0], picture);
  const Solution truth = clean.solved(), squares = spoilt.solved();
  const auto worst = [&](const Solution& s) {
    double most = 0;
    for (std::size_t i = 0; i < eta_index; ++i) most = std::max(most, std::abs(s.parameters[i] - truth.parameters[i]));
    return most;
  };
  for (const auto kind : {RobustLoss::Kind::huber, RobustLoss::Kind::cauchy}) {
    spoilt.settings.loss.kind = kind;
    const Solution robust = spoilt.solved();
    EXPECT_TRUE(robust.converged);
    EXPECT_LT(worst(robust), 0.25 * worst(squares));
    EXPECT_LT(robust.pixel_weight_share[0], 0.99);
    const Uncertainty u = uncertainty(robust, spoilt.settings.free);
    for (int i = 0; i < eta_index; ++i)
      EXPECT_LT(
          std::abs(robust.parameters[static_cast<std::size_t>(i)] - truth.parameters[static_cast<std::size_t>(i)]),
          5 * std::sqrt(u.covariance(i, i)))
          << parameter_name(i);
  }
}

TEST(Robust, WeightsHaveTheirSlopes) {
  for (const auto kind : {RobustLoss::Kind::squares, RobustLoss::Kind::huber, RobustLoss::Kind::cauchy}) {
    const RobustLoss loss{kind};
    for (const double d : {0.3, 1.0, 2.0, 8.0})
      EXPECT_NEAR(loss.slope(d), (loss.weight(d + 1e-6) - loss.weight(d - 1e-6)) / 2e-6, 1e-8);
    EXPECT_EQ(loss.weight(0), 1);
  }
}

TEST(Robust, ASandwichOfNormalNoiseIsTheUsualCovariance) {
  Sphere sphere;
  const Uncertainty usual = uncertainty(sphere.solved(), sphere.settings.free);
  sphere.settings.loss.kind = RobustLoss::Kind::huber;
  const Uncertainty robust = uncertainty(sphere.solved(), sphere.settings.free);
  // Efficiency near 95 %, and a sandwich of 200 pixels is itself uncertain by some 10 %.
  for (int i = 0; i < eta_index; ++i)
    EXPECT_NEAR(std::sqrt(robust.covariance(i, i) / usual.covariance(i, i)), 1.03, 0.25) << parameter_name(i);
}

TEST(Priors, NarrowWhatTheyAreAboutAndAreNamed) {
  Sphere sphere;
  const double truth = std::log(0.17);
  sphere.settings.priors = {{1, truth, 1e-4}};
  const Solution s = sphere.solved();
  const Uncertainty u = uncertainty(s, sphere.settings.free);
  EXPECT_NEAR(s.parameters[1], truth, 3e-4);
  EXPECT_NEAR(std::sqrt(u.covariance(1, 1)), 1e-4, 1e-6);
  EXPECT_EQ(s.prior_rows, 1);
  EXPECT_THAT(u.notes, Contains(HasSubstr("sigma_a_per_mm[G] comes from its prior")));
}

TEST(Grey, OneChannelIsFittedAndRepeated) {
  Sphere sphere;
  Image picture(20, 20, {"Y"});
  const Image rgb = operator_image(sphere.op, dipole(), sphere.scene.materials[0]);
  for (std::size_t p = 0; p < picture.data.size(); ++p) picture.data[p] = rgb.data[4 * p];
  sphere.targets.clear();
  sphere.targets.push_back(make_target(sphere.op, picture, "grey"));
  const Solution s = solve(sphere.targets, dipole(), test::library_material("skin2"), sphere.settings);
  for (std::size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(std::exp(s.parameters[c]), 0.032, 2e-4);
    EXPECT_NEAR(std::exp(s.parameters[c + 3]), 0.74, 2e-3);
  }
  const Uncertainty u = uncertainty(s, sphere.settings.free);
  EXPECT_EQ(u.parameters[2].sd, u.parameters[0].sd);
}

TEST(KnownNoise, TellsAModelThatDoesNotFit) {
  Sphere sphere;
  const Image clean = operator_image(sphere.op, dipole(), sphere.scene.materials[0]);
  const std::array<double, 3> sd = [&] {
    Image copy = clean;
    return add_noise(copy, 0.01, 1);
  }();
  sphere.targets[0].noise.known = true;
  sphere.targets[0].noise.read_sd = sd;
  const Solution s = sphere.solved();
  EXPECT_NEAR(s.chi_squared / s.freedom, 1, 4 * std::sqrt(2 / s.freedom));
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(s.noise_sd[0][c] / sd[c], 1, 1e-12);
  sphere.targets[0].noise.read_sd = {sd[0] / 2, sd[1] / 2, sd[2] / 2};
  const Solution tight = sphere.solved();
  EXPECT_NEAR(tight.chi_squared / tight.freedom, 4, 16 * std::sqrt(2 / s.freedom));
}

TEST(DiagnosisTest, SaysWhatAFlatPictureDetermines) {
  Scene scene = test::make_scene(make_slab({100, 100, 30}, 3000), test::library_material("skin1"), 20, 24);
  scene.lights = {DirectionalLight{{0, 0, -1}, Rgb(1), 0}};
  TransportOperator op = build_operator(scene, 0, EtaNodes(1.3), test::small_operator(4000));
  Image picture = operator_image(op, dipole(), scene.materials[0]);
  add_noise(picture, 0.01, 1);
  std::vector<FitTarget> targets;
  targets.push_back(make_target(std::move(op), picture, "flat"));
  SolveSettings settings;
  settings.free.eta = false;
  const Solution s = solve(targets, dipole(), test::library_material("skin2"), settings);
  const Uncertainty u = uncertainty(s, settings.free);
  const Diagnosis d = diagnose(s, u);
  EXPECT_FALSE(d.determined);
  EXPECT_THAT(d.refusal, HasSubstr("do not determine sigma_a_per_mm[R]"));
  EXPECT_THAT(d.refusal, HasSubstr("the albedo alpha' only"));
  EXPECT_THAT(d.refusal, HasSubstr("add a beam, an edge or a side light"));
  const std::vector<Advice> advice = advise(scene, 0, dipole(), s, u, settings.free, 0.01, {16, 2000});
  ASSERT_GE(advice.size(), 8u);
  EXPECT_GT(advice.front().factor, 10);
  EXPECT_THAT(advice.front().what, HasSubstr("beam"));
  for (std::size_t i = 1; i < advice.size(); ++i) EXPECT_LE(advice[i].factor, advice[i - 1].factor);
}

TEST(DiagnosisTest, KnowsWhenAllIsDetermined) {
  const Sphere sphere;
  const Solution s = sphere.solved();
  const Diagnosis d = diagnose(s, uncertainty(s, sphere.settings.free));
  EXPECT_TRUE(d.determined);
  EXPECT_EQ(d.refusal, "");
  EXPECT_EQ(d.channels[0].sentence, "both coefficients");
  EXPECT_NEAR(d.channels[1].quantities[1].value, std::sqrt(3 * 0.17 * 1.05), 0.05);
}

TEST(ResidualStructure, OfNoiseIsNothingAndOfAGradientIsAll) {
  Image noise(60, 60, {"R", "G", "B", "A"}), slope = noise;
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      for (int c = 0; c < 3; ++c) noise.at(x, y, c) = normal(random), slope.at(x, y, c) = static_cast<float>(x - 30);
      noise.at(x, y, 3) = slope.at(x, y, 3) = 1;
    }
  // Three channels of 7080 pairs.
  EXPECT_LT(std::abs(neighbour_correlation(noise)), 4 / std::sqrt(3 * 7080.0));
  EXPECT_GT(neighbour_correlation(slope), 0.95);
}

}  // namespace
}  // namespace opaline
