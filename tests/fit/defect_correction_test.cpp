// A fit with a wrong operator, corrected by a right reference: its solution and its covariance must be those of the fit
// with the right operator, which is known here because the reference is an operator too.
#include "fit/defect_correction.h"

#include "fit/bootstrap.h"
#include "fit/profile_interval.h"
#include "fit/reduced_picture.h"
#include "fit/reference_noise.h"
#include "fit/rendered_reference.h"
#include "tests/support/fit_job_fixture.h"

#include <gtest/gtest.h>

#include <random>

namespace opaline {
namespace {

const ProfileInfo& wrong() { return *find_profile("better_dipole"); }
const ProfileInfo& right() { return *find_profile("transport_table"); }

class DefectCorrection : public ::testing::Test {
 protected:
  DefectCorrection()
      : scene_(test::sphere_scene("skin1", 24)),
        op_(build_operator(scene_, 0, test::free_eta(), test::small_operator())) {
    settings_.starts = 2;
    settings_.free.eta = false;
  }

  const Material& truth() const { return scene_.materials.front(); }

  std::vector<FitTarget> targets(double noise, unsigned seed) {
    Image picture = operator_image(op_, right(), truth());
    if (noise > 0) add_noise(picture, noise, seed);
    std::vector<FitTarget> all;
    all.push_back(make_target(op_, picture, "picture"));
    return all;
  }

  /// Pictures of the right operator; with noise, the same in every call.
  Reference reference(const std::vector<FitTarget>& targets, double noise = 0, unsigned seed = 3) {
    return [this, &targets, noise, seed](const ParameterVector& at) {
      ReferencePicture made{target_rows(targets[0], right(), to_material(at, truth(), settings_.free)), {}};
      std::mt19937_64 random(seed);
      std::normal_distribution<double> normal(
          0, noise * std::sqrt(made.rows.squaredNorm() / static_cast<double>(made.rows.size())));
      made.noise.known = noise > 0;
      if (noise > 0)
        for (double& value : made.rows.reshaped()) value += normal(random);
      ++calls_;
      return std::vector<ReferencePicture>{made};
    };
  }

  Material start() const {
    Material m = test::neutral_material();
    m.eta = truth().eta;
    return m;
  }

  Scene scene_;
  TransportOperator op_;
  SolveSettings settings_;
  int calls_ = 0;
};

TEST(ReferenceNoise, AddsUpWithTheScale) {
  NoiseModel a, b;
  a.known = b.known = true, b.rough = true;
  a.read_sd = {3, 0, 0}, b.read_sd = {2, 0, 0};
  a.shot = {1, 0, 0}, b.shot = {0.5, 0, 0};
  a.relative = {0.3, 0, 0}, b.relative = {0.4, 0, 0};
  const NoiseModel sum = sum_of_noise(a, b, 2);
  for (const double s : {0.0, 1.0, 7.0})  // b's picture is s/2 where the sum is compared with s
    EXPECT_NEAR(sum.variance(0, s), a.variance(0, s) + 4 * b.variance(0, s / 2), 1e-12);
  EXPECT_TRUE(sum.rough);
  a.known = false;
  EXPECT_FALSE(sum_of_noise(a, b, 2).known) << "the residual shows both";
}

TEST(ReferenceNoise, NeighboursLeaveThePixelOut) {
  TransportOperator op =
      build_operator(test::sphere_scene("skin1", 4, 200), 0, EtaNodes(1.3), test::small_operator(200));
  op.width = 7, op.height = 3;
  op.pixels = {0, 3, 6, 10, 20};  // (0,0) (3,0) (6,0) (3,1) (6,2)
  Eigen::MatrixXd rows(5, 1);
  rows << 1, 10, 100, 1000, 10000;
  const Eigen::MatrixXd mean = neighbours_mean(rows, op);
  EXPECT_EQ(mean(0, 0), 1) << "alone";
  EXPECT_EQ(mean(1, 0), 1000);
  EXPECT_EQ(mean(2, 0), 10000);
  EXPECT_EQ(mean(3, 0), 10);
  EXPECT_EQ(mean(4, 0), 100);
}

TEST_F(DefectCorrection, FindsWhatTheReferenceWouldHaveFound) {
  std::vector<FitTarget> corrected = targets(0.01, 7);
  const std::vector<FitTarget> direct = targets(0.01, 7);
  const Solution wanted = solve(direct, right(), start(), settings_);
  Solution s = solve(corrected, wrong(), start(), settings_);
  const ParameterVector before = s.parameters;
  CorrectionSettings R;
  const Correction c = correct_by_reference(corrected, wrong(), start(), settings_, reference(corrected), {}, s);
  EXPECT_TRUE(c.converged);
  EXPECT_TRUE(c.measured);
  EXPECT_EQ(c.renders, calls_);
  EXPECT_GE(c.renders, static_cast<int>(c.steps.size()) + 2) << "one more for each kind of parameter";
  const Uncertainty u = uncertainty(s, settings_.free), u_wanted = uncertainty(wanted, settings_.free);
  double worst_before = 0;
  for (int i = 0; i < eta_index; ++i) {
    const auto at = static_cast<std::size_t>(i);
    const double best = u_wanted.covariance(i, i), variance = u.covariance(i, i);
    worst_before = std::max(worst_before, std::abs(before[at] - wanted.parameters[at]) / std::sqrt(best));
    // The operator's weights are not the best: what is lost shows in the interval, and is all the two differ by
    // (Hausman 1978).
    EXPECT_GT(variance, 0.95 * best) << parameter_name(i);
    EXPECT_LT(variance, 1.6 * best) << parameter_name(i);
    EXPECT_LT(std::abs(s.parameters[at] - wanted.parameters[at]),
              4 * std::sqrt(std::max(variance - best, 0.0)) + 0.3 * std::sqrt(best))
        << parameter_name(i);
  }
  EXPECT_GT(worst_before, 10) << "the wrong operator is not wrong";
}

TEST_F(DefectCorrection, WithoutNoiseItIsTheReferencesFitToTheLastDigits) {
  std::vector<FitTarget> all = targets(0, 0);
  Solution s = solve(all, wrong(), start(), settings_);
  CorrectionSettings rules;
  rules.small_step = 0;
  const Correction c = correct_by_reference(all, wrong(), start(), settings_, reference(all), rules, s);
  EXPECT_TRUE(c.converged) << c.steps.size();
  EXPECT_LE(c.steps.size(), 8u);
  const ParameterVector wanted = to_parameters(truth(), {});
  for (std::size_t i = 0; i < eta_index; ++i) EXPECT_NEAR(s.parameters[i], wanted[i], 1e-4);
  EXPECT_GT(c.steps.front().defect, 0.1);
  // What the report shows: the operator's picture and what was taken off are the reference's.
  const Eigen::MatrixXd shown = target_rows(all[0], wrong(), to_material(s.parameters, truth(), settings_.free)) +
                                all[0].offset,
                        made = target_rows(all[0], right(), truth());
  EXPECT_LT((shown - made).norm(), 1e-4 * made.norm());
}

TEST_F(DefectCorrection, AnOperatorThatIsNearEnoughIsNotMeasured) {
  std::vector<FitTarget> all = targets(0.01, 7);
  Solution s = solve(all, right(), start(), settings_);
  const ParameterVector before = s.parameters;
  const Correction c = correct_by_reference(all, right(), start(), settings_, reference(all), {}, s);
  EXPECT_TRUE(c.converged);
  EXPECT_FALSE(c.measured);
  EXPECT_EQ(c.renders, 1);
  EXPECT_EQ(c.renders_saved, 2);
  for (std::size_t i = 0; i < eta_index; ++i) EXPECT_NEAR(s.parameters[i], before[i], 1e-6);
}

TEST_F(DefectCorrection, FewerValuesThanUnknownsDetermineNothing) {
  const std::vector<FitTarget> all = targets(0.01, 7);
  Solution s = solve(all, right(), start(), settings_);
  EXPECT_TRUE(uncertainty(s, settings_.free).parameters[0].identifiable);
  s.freedom = -1;
  const Uncertainty u = uncertainty(s, settings_.free);
  for (int i = 0; i < eta_index; ++i) EXPECT_FALSE(u.parameters[static_cast<std::size_t>(i)].identifiable);
  EXPECT_EQ(u.parameters[0].reason, "there are fewer values than unknowns");
}

TEST_F(DefectCorrection, RepetitionsMoveAsTheReferenceDoes) {
  const std::vector<FitTarget> all = targets(0.01, 7);
  const Solution s = solve(all, right(), start(), settings_);
  const FitProblem problem(all, s.whitened, right(), settings_, s.bounds);
  const Eigen::Index n = s.jacobian.cols();
  const Bootstrap plain = bootstrap(problem, s, 5, 1),
                  twice = bootstrap(problem, s, 5, 1, 2 * Eigen::MatrixXd::Identity(n, n));
  for (Eigen::Index i = 0; i < eta_index; ++i) {
    EXPECT_NEAR(twice.sd[i], plain.sd[i] / 2, 1e-9);
    EXPECT_NEAR(twice.bias[i], plain.bias[i] / 2, 1e-9);
  }
}

/// Repetitions with new noise in picture and reference: the intervals are what the results scatter by.
TEST_F(DefectCorrection, IntervalsHoldTheNoiseOfBoth) {
  constexpr int repetitions = 40;
  const ParameterVector true_values = to_parameters(truth(), {});
  std::array<double, eta_index> squares{};
  for (int r = 0; r < repetitions; ++r) {
    std::vector<FitTarget> all = targets(0.004, 100 + r);
    Solution s = solve(all, wrong(), start(), settings_);
    correct_by_reference(all, wrong(), start(), settings_, reference(all, 0.01, 1000 + r), {}, s);
    const Uncertainty u = uncertainty(s, settings_.free);
    for (int i = 0; i < eta_index; ++i) {
      const auto at = static_cast<std::size_t>(i);
      squares[at] += std::pow(s.parameters[at] - true_values[at], 2) / u.covariance(i, i) / repetitions;
    }
  }
  for (int i = 0; i < eta_index; ++i) {
    EXPECT_LT(std::abs(squares[static_cast<std::size_t>(i)] - 1), 4 * std::sqrt(2.0 / repetitions))
        << parameter_name(i);
  }
}

/// Through the whole job, with renders: the operator of few nodes is made right by the gather, and what it says of
/// itself is kept.
class CorrectedJob : public test::FitJobTest {};

TEST_F(CorrectedJob, IsTheFitOfTheTechnique) {
  const nlohmann::json document = test::sphere_document();
  const Scene scene = parse_scene(document, folder_.file("scene.json"), synthetic_shapes());
  const std::map<std::string, std::string> gather = {
      {"profile", "standard_dipole"}, {"max_relative_error", "1e-5"}, {"discretisation", "fixed"}};
  FitJob job = job_;
  job.targets = {image_file("clean.exr", test::picture_of(scene, job.op, "hierarchical", gather))};
  job.solve.free.eta = false;
  const auto worst = [&](const FitReport& report) {
    const ParameterVector truth = to_parameters(scene.materials[0], {});
    double most = 0;
    for (int i = 0; i < eta_index; ++i)
      most = std::max(most, std::abs(test::relative_error(i, report.solution.parameters, truth)));
    return most;
  };
  const FitReport plain = run(job);
  job.reference.emplace().technique = "hierarchical";
  job.reference->settings = gather;
  const FitReport corrected = run(job);
  EXPECT_FALSE(plain.correction);
  ASSERT_TRUE(corrected.correction);
  EXPECT_TRUE(corrected.correction->converged);
  EXPECT_GT(corrected.correction->renders_saved, 0);
  EXPECT_LT(worst(corrected), 1e-5);
  EXPECT_LT(worst(corrected), 0.1 * worst(plain));
  for (const ParameterEstimate& e : corrected.uncertainty.parameters)  // not widened to where the starts ended
    if (e.free) {
      EXPECT_LT(e.high / e.low - 1, 8 * e.sd / e.value);
    }
  EXPECT_TRUE(fit_json(corrected).contains("correction"));
  // The report's pictures are the data and the technique's, not the corrected data and the operator's.
  const Image data = read_image(job.targets[0]);
  for (std::size_t k = 0; k < data.pixel_count(); ++k)
    if (data.data[4 * k + 3] > 0) {
      ASSERT_NEAR(corrected.targets[0].picture.data[4 * k], data.data[4 * k], 1e-6);
    }
}

TEST(RenderedReference, HasRandomNumbersOfItsOwn) {
  const Scene scene = test::sphere_scene("skin1", 8, 200);
  const OperatorSettings op = test::small_operator(200);
  std::vector<FitTarget> targets;
  RenderOptions options;
  options.shared = {op.samples, op.irradiance};
  const Image picture = render_scene(scene, options).image;
  targets.push_back(make_target(build_operator(scene, 0, EtaNodes(scene.materials[0].eta), op), picture, "picture"));
  const std::vector<TargetScene> scenes = {{std::make_shared<const Scene>(scene), 0}};
  const FreeParameters free;
  const auto off = [&](const std::string& technique, const std::map<std::string, std::string>& settings) {
    options.technique = technique, options.settings = settings;
    const Image direct = render_scene(scene, options).image;
    const ReferencePicture made = rendered_reference(scenes, targets, scene.materials[0], free,
                                                     options)(to_parameters(scene.materials[0], {}))[0];
    EXPECT_EQ(made.noise.known, technique == "path_traced");
    double square = 0;
    for (std::size_t p = 0; p < targets[0].rows(); ++p)
      square += std::pow(
          made.rows(static_cast<Eigen::Index>(p), 0) - static_cast<double>(direct.data[targets[0].op.pixels[p] * 4u]),
          2);
    return std::sqrt(square) / made.rows.col(0).norm();
  };
  EXPECT_LT(off("hierarchical", {}), 1e-6);
  EXPECT_GT(off("path_traced", {{"paths", "4"}}), 0.05);
}

/// Materials of which the operator alone is too far off, and two that hold a channel without any scattering.
TEST(LibraryMaterials, ComeBackWithTheReference) {
  OperatorSettings op = test::small_operator(800);
  RenderOptions options;
  options.technique = "hierarchical";
  options.settings = {{"profile", "transport_table"}, {"max_relative_error", "1e-5"}, {"discretisation", "fixed"}};
  options.shared = {op.samples, op.irradiance};
  double worst_before = 0;
  for (const char* name : {"Espresso", "Ketchup", "Pepsi", "Merlot"}) {
    const Scene scene = test::sphere_scene(name, 10, 500);
    std::vector<FitTarget> targets;
    targets.push_back(
        make_target(build_operator(scene, 0, test::free_eta(), op), render_scene(scene, options).image, name));
    const Material start = test::neutral_material();
    const SolveSettings settings;
    Solution s = solve(targets, right(), start, settings);
    const std::vector<TargetScene> scenes = {{std::make_shared<const Scene>(scene), 0}};
    const ParameterVector truth = to_parameters(scene.materials[0], s.bounds), before = s.parameters;
    const Correction c = correct_by_reference(
        targets, right(), start, settings, rendered_reference(scenes, targets, start, settings.free, options), {}, s);
    EXPECT_TRUE(c.converged) << name;
    const Uncertainty u = uncertainty(s, settings.free);
    for (int i = 0; i < parameter_count; ++i) {
      const bool scatters = i == eta_index || scene.materials[0].sigma_s_prime[i % 3] > 0;
      EXPECT_EQ(u.parameters[static_cast<std::size_t>(i)].identifiable, scatters) << name << " " << parameter_name(i);
      if (!scatters) continue;
      worst_before = std::max(worst_before, std::abs(test::relative_error(i, before, truth)));
      EXPECT_LT(std::abs(test::relative_error(i, s.parameters, truth)), 1e-3) << name << " " << parameter_name(i);
    }
  }
  EXPECT_GT(worst_before, 1e-2) << "the operator alone is good enough: this shows nothing";
}

TEST_F(CorrectedJob, RefusesWhatCannotBeRendered) {
  FitJob job = job_;
  job.reference.emplace().technique = "no_such_technique";
  expect_wrong(job, {"no_such_technique", "hierarchical", "path_traced"});
  job.reference->technique = "path_traced";
  job.reference->settings = {{"pathss", "3"}};
  expect_wrong(job, {"pathss", "paths"});
}

}  // namespace
}  // namespace opaline
