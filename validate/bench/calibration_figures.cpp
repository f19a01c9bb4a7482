// Is what a fit says of its errors true? Repetitions of noisy pictures on two shapes and three materials, and what the
// examination of a large fit costs.
#include "datasets_synthetic/shapes/shapes.h"
#include "fit/bootstrap.h"
#include "fit/compare_models.h"
#include "fit/profile_interval.h"
#include "model/materials/library.h"
#include "render/stopwatch.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace opaline::bench {
namespace {

const ProfileInfo& transport() { return *find_profile("transport_table"); }

Scene small_scene(const std::string& shape, const std::string& mesh, const std::string& material, int film) {
  SceneChoice choice;
  choice.mesh = shape == "sphere" ? "" : mesh;
  choice.material = material;
  choice.film = film;
  choice.height = 20;
  Scene scene = bench_scene(choice);
  if (shape == "sphere") scene.objects.front().mesh = make_sphere(10, 5000);
  return scene;
}

Eigen::MatrixXd noisy(Eigen::MatrixXd rows, const std::array<double, 3>& sd, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  for (Eigen::Index c = 0; c < rows.cols(); ++c)
    for (Eigen::Index p = 0; p < rows.rows(); ++p) rows(p, c) += sd[static_cast<std::size_t>(c)] * normal(random);
  return rows;
}

struct Calibration {
  double worst_ratio = 0;  ///< of the variance over the Cramer-Rao bound, furthest from 1
  double least_cover = 1, most_cover = 0;
  int determined = 0;
};

/// Repetitions with noise of 1 % of each channel's RMS; the bound is the curvature at the truth with the noise known.
Calibration calibrate(const Scene& scene, int repetitions) {
  OperatorSettings op;
  op.samples = 20000;
  const Material& truth = scene.materials.front();
  const TransportOperator gathered =
      build_operator(scene, 0, EtaNodes(ParameterBounds().eta_min, ParameterBounds().eta_max, 8), op);
  const FitTarget clean = make_target(gathered, operator_image(gathered, transport(), truth), "clean");
  std::array<double, 3> sd{};
  for (int c = 0; c < 3; ++c)
    sd[static_cast<std::size_t>(c)] = 0.01 * std::sqrt(clean.products(c, c) / static_cast<double>(clean.rows()));
  SolveSettings settings;
  settings.starts = 1;
  std::vector<FitTarget> known{clean};
  known[0].noise.known = true;
  known[0].noise.read_sd = sd;
  const Uncertainty bound = uncertainty(solve(known, transport(), truth, settings), settings.free);
  const ParameterVector at = to_parameters(truth, {});
  Eigen::MatrixXd error(repetitions, parameter_count);
  Eigen::MatrixXi covered(repetitions, parameter_count);
  tbb::parallel_for(0, repetitions, [&](int i) {
    std::vector<FitTarget> targets{clean};
    replace_picture(targets[0], noisy(clean.picture, sd, static_cast<std::uint64_t>(i) + 1));
    const Solution s = solve(targets, transport(), truth, settings);
    Uncertainty u = uncertainty(s, settings.free);
    const FitProblem problem(targets, s.whitened, transport(), settings, s.bounds);
    profile_intervals(problem, s, u);
    for (int k = 0; k < parameter_count; ++k) {
      const auto j = static_cast<std::size_t>(k);
      const double value = natural_value(k, at[j]);
      error(i, k) = s.parameters[j] - at[j];
      covered(i, k) = u.parameters[j].low <= value && value <= u.parameters[j].high;
    }
  });
  Calibration out;
  for (int k = 0; k < parameter_count; ++k) {
    if (!bound.parameters[static_cast<std::size_t>(k)].identifiable) continue;
    ++out.determined;
    const double ratio = error.col(k).squaredNorm() / repetitions / bound.covariance(k, k);
    if (std::abs(ratio - 1) > std::abs(out.worst_ratio)) out.worst_ratio = ratio - 1;
    const double cover = covered.col(k).cast<double>().mean();
    out.least_cover = std::min(out.least_cover, cover), out.most_cover = std::max(out.most_cover, cover);
  }
  return out;
}

}  // namespace

std::vector<Figure> calibration_figures(int repetitions, const std::string& mesh) {
  std::vector<Figure> figures;
  const std::string object = mesh.empty() ? "bust" : mesh;
  for (const std::string& shape : {std::string("sphere"), object})
    for (const char* material : {"skin1", "marble", "skimmilk"}) {
      const Calibration c = calibrate(small_scene(shape, mesh, material, 40), repetitions);
      const std::string name = fmt::format("{} of {}, {} repetitions: ", shape, material, repetitions);
      const std::string note = fmt::format("{} parameters; of a variance itself 4 sd are {:.2f}", c.determined,
                                           4 * std::sqrt(2.0 / repetitions));
      figures.push_back({name + "variance / Cramer-Rao - 1, furthest", std::abs(c.worst_ratio), 0.1, true, "", note});
      figures.push_back({name + "95 % intervals hold the truth, least", c.least_cover, 0.93, false, "", ""});
      figures.push_back({name + "95 % intervals hold the truth, most", c.most_cover, 0.97, true, "", ""});
    }
  return figures;
}

namespace {

/// The large products of the reduction: three triangular ones (orthonormal_operator.h).
double reduction_flops(const std::vector<FitTarget>& targets) {
  double sum = 0;
  for (const FitTarget& t : targets)
    for (const Eigen::MatrixXf& q : t.basis.q)
      sum += 3 * static_cast<double>(q.cols()) * static_cast<double>(q.rows()) * static_cast<double>(q.rows());
  return sum;
}

}  // namespace

std::vector<Figure> examination_figures(const SceneChoice& choice) {
  SceneChoice large = choice;
  large.film = 512;
  Scene scene = bench_scene(large);
  const Material truth = scene.materials.front();
  std::vector<FitTarget> targets;
  double gather = 0, reduce = 0, patches = 0;
  Stopwatch watch;
  for (int view = 0; view < 2; ++view) {
    if (view == 1) scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(0.9, -0.3, -0.3)), Rgb(3), 0}};
    OperatorSettings op;
    op.samples = choice.samples;
    watch.lap();
    TransportOperator gathered =
        build_operator(scene, 0, EtaNodes(ParameterBounds().eta_min, ParameterBounds().eta_max, 8), op);
    gather += watch.lap();
    Image picture = operator_image(gathered, transport(), truth);
    watch.lap();
    FitTarget target = make_target(std::move(gathered), picture, "view");
    reduce += watch.lap();
    std::array<double, 3> sd{};
    for (int c = 0; c < 3; ++c)
      sd[static_cast<std::size_t>(c)] = 0.01 * std::sqrt(target.products(c, c) / static_cast<double>(target.rows()));
    replace_picture(target, noisy(target.picture, sd, static_cast<std::uint64_t>(view) + 1));
    for (const char* kind : {"clusters", "cells", "cell_parts"})
      patches += static_cast<double>(target.op.counters.done.at(kind));
    targets.push_back(std::move(target));
  }
  const SolveSettings settings;
  const Solution s = solve(targets, transport(), truth, settings);
  const Uncertainty u = uncertainty(s, settings.free);
  const ModelComparison models = compare_models(targets, "transport_table", s, u, truth, settings);
  const FitProblem problem(targets, s.whitened, transport(), settings, s.bounds);
  const Bootstrap repeated = bootstrap(problem, s, 200, 1);
  return {{"operators of two views of 512 x 512, gather and reduction", gather + reduce, 15, true, "s",
           fmt::format("gather {:.1f} ({:.1f} ns a patch), reduction {:.1f} ({:.0f} GFLOP/s in double), {} + {} pixels",
                       gather, 1e9 * gather / patches, reduce, 1e-9 * reduction_flops(targets) / reduce,
                       targets[0].rows(), targets[1].rows())},
          {"solve, 8 starts", s.seconds, 0, true, "s", fmt::format("{} iterations", s.iterations)},
          {"all models compared", models.seconds, 3, true, "s", fmt::format("{} profiles", models.models.size())},
          {"bootstrap of 200", repeated.seconds, 2, true, "s", fmt::format("{} failed", repeated.failed)},
          {"peak memory", peak_rss() / (1 << 30), 2, true, "GiB", "all of the benchmark so far"}};
}

}  // namespace opaline::bench
