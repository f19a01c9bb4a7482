// Recovery, cost and calibration of the fit on one scene.
#include "validate/bench/figures.h"

#include "fit/fit_job.h"
#include "render/stopwatch.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <random>

namespace opaline::bench {
namespace {

/// discretisation: fixed, the very cells of the operator; controlled, cells it knows nothing of.
Image reference_picture(const Scene& scene, std::size_t samples, const char* discretisation = "fixed") {
  const SharedScene shared(scene, {samples, {}});
  const Technique& technique = find_technique("hierarchical");
  const Settings settings(technique.settings, {{"max_relative_error", "1e-4"}, {"discretisation", discretisation}});
  return shade(scene, shared.view, technique.prepare(shared, settings)->render(shared.view).exitance);
}

/// RMS of a channel over the object.
double channel_rms(const Image& picture, const TransportOperator& op, std::size_t c) {
  double sum = 0;
  for (const std::uint32_t pixel : op.pixels) sum += std::pow(static_cast<double>(picture.data[pixel * 4u + c]), 2);
  return std::sqrt(sum / static_cast<double>(op.rows()));
}

std::array<double, 3> noise_of(const Image& picture, const TransportOperator& op, double relative) {
  return {relative * channel_rms(picture, op, 0), relative * channel_rms(picture, op, 1),
          relative * channel_rms(picture, op, 2)};
}

Image with_noise(Image picture, const TransportOperator& op, const std::array<double, 3>& sd, unsigned seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  for (const std::uint32_t pixel : op.pixels)
    for (std::size_t c = 0; c < 3; ++c) picture.data[pixel * 4u + c] += static_cast<float>(sd[c] * normal(generator));
  return picture;
}

struct Fitted {
  Solution solution;
  Uncertainty uncertainty;
  double reduce_seconds = 0;
};

Fitted fit_picture(const TransportOperator& op, const Image& picture, int starts) {
  std::vector<FitTarget> targets;
  Stopwatch watch;
  targets.push_back(make_target(op, picture, "target"));
  Fitted fitted;
  fitted.reduce_seconds = watch.lap();
  SolveSettings settings;
  settings.starts = starts;
  Material neutral;
  neutral.sigma_a = Rgb(0.05), neutral.sigma_s_prime = Rgb(1), neutral.eta = 1.35;
  fitted.solution = solve(targets, *find_profile("standard_dipole"), neutral, settings);
  fitted.uncertainty = uncertainty(fitted.solution, settings.free);
  return fitted;
}

double worst_error(const Fitted& fitted, const ParameterVector& truth) {
  double worst = 0;
  for (int i = 0; i < parameter_count; ++i) {
    const double t = natural_value(i, truth[static_cast<std::size_t>(i)]);
    worst = std::max(worst, std::abs(fitted.uncertainty.parameters[static_cast<std::size_t>(i)].value - t) / t);
  }
  return worst;
}

/// Cramer-Rao bound on the sd of (ln sigma, eta), by central differences through the renderer.
Eigen::VectorXd cramer_rao(const Scene& scene, const TransportOperator& op, const std::array<double, 3>& sd,
                           std::size_t samples) {
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(parameter_count, parameter_count);
  const Material truth = scene.materials.front();
  const ParameterVector at = to_parameters(truth, {});
  Eigen::MatrixXd jacobian(static_cast<Eigen::Index>(3 * op.rows()), parameter_count);
  for (int i = 0; i < parameter_count; ++i) {
    const double step = i == eta_index ? 0.01 : 0.02;
    Image side[2];
    for (int s = 0; s < 2; ++s) {
      ParameterVector moved = at;
      moved[static_cast<std::size_t>(i)] += (s ? 1 : -1) * step;
      Scene changed = scene;
      changed.materials.front() = to_material(moved, truth);
      side[s] = reference_picture(changed, samples);
    }
    for (std::size_t p = 0; p < op.rows(); ++p)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t at_value = op.pixels[p] * 4u + c;
        jacobian(static_cast<Eigen::Index>(3 * p + c), i) =
            static_cast<double>(side[1].data[at_value] - side[0].data[at_value]) / (2 * step * sd[c]);
      }
  }
  information = jacobian.transpose() * jacobian;
  return information.inverse().diagonal().cwiseSqrt();
}

}  // namespace

std::vector<Figure> fit_figures(const SceneChoice& choice) {
  const Scene scene = bench_scene(choice);
  const ParameterVector truth = to_parameters(scene.materials.front(), {});
  OperatorSettings settings;
  settings.samples = choice.samples;
  const EtaNodes nodes(ParameterBounds().eta_min, ParameterBounds().eta_max, 8);
  const double operator_seconds = median_seconds(choice.runs, [&] { build_operator(scene, 0, nodes, settings); });
  const TransportOperator op = build_operator(scene, 0, nodes, settings);
  const ProfileInfo& profile = *find_profile("standard_dipole");
  const OperatorError own = operator_error(scene, op, settings, profile, scene.materials.front(), 0);
  const Image reference = reference_picture(scene, choice.samples),
              expanded = operator_image(op, profile, scene.materials.front());
  const Fitted one = fit_picture(op, reference, 1), exact = fit_picture(op, reference, 8),
               self = fit_picture(op, expanded, 8);
  const Fitted finer = fit_picture(op, reference_picture(scene, choice.samples, "controlled"), 8);
  const std::array<double, 3> sd = noise_of(reference, op, 0.01);
  const Fitted noisy = fit_picture(op, with_noise(reference, op, sd, 7), 8);
  const Eigen::VectorXd bound = cramer_rao(scene, op, sd, choice.samples);
  double worst_z = 0, worst_ratio = 0;
  for (int i = 0; i < parameter_count; ++i) {
    const double reported = std::sqrt(noisy.uncertainty.covariance(i, i));
    worst_z = std::max(
        worst_z, std::abs(noisy.solution.parameters[static_cast<std::size_t>(i)] - truth[static_cast<std::size_t>(i)]) /
                     reported);
    worst_ratio = std::max(worst_ratio, std::abs(reported / bound[i] - 1));
  }
  return {
      {"operator, all of it", operator_seconds, 3, true, "s",
       fmt::format("{} pixels x {} columns", op.rows(), op.columns())},
      {"  its own error on the picture (rms)", own.rms, 1e-4, true, "",
       fmt::format("certified: at most {:.1e}", own.at_most)},
      {"reduction to residuals", exact.reduce_seconds, 0, true, "s", ""},
      {"solve from one start and polish", one.solution.seconds, 0.05, true, "s",
       fmt::format("{} iterations", one.solution.iterations)},
      {"whole fit, 8 starts", operator_seconds + exact.reduce_seconds + exact.solution.seconds, 5, true, "s",
       fmt::format("{} iterations", exact.solution.iterations)},
      {"peak memory", peak_rss() / (1 << 30), 1, true, "GiB", "all of the benchmark so far"},
      {"noise-free reference target: worst relative error", worst_error(exact, truth), 1e-3, true, "", ""},
      {"  the same from cells finer than the operator's", worst_error(finer, truth), 0, true, "",
       "discretisation=controlled, 1e-4"},
      {"target made by the operator: worst relative error", worst_error(self, truth), 1e-7, true, "", ""},
      {"1 % noise: worst error in reported sd", worst_z, 3, true, "sd", ""},
      {"1 % noise: reported sd against Cramer-Rao, worst deviation", worst_ratio, 0.2, true, "", "14 renders"},
      {"1 % noise: relative RMSE of the refit / noise", noisy.solution.relative_rmse / 0.01, 1.05, true, "", ""},
      {"1 % noise: worst relative error", worst_error(noisy, truth), 0, true, "", ""},
  };
}

}  // namespace opaline::bench
