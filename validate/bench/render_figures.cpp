// Figures of the renderer: pictures of one scene, and the gather itself on a sphere.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/irradiance/profile_gather.h"
#include "render/stopwatch.h"
#include "render/techniques/technique.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>

namespace opaline::bench {
namespace {

double rms_error(const Frame& frame, const Frame& reference, std::size_t step) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < reference.exitance.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double r = static_cast<double>(reference.exitance[i][c]);
      const double d = static_cast<double>(frame.exitance[i * step][c]) - r;
      error += d * d;
      norm += r * r;
    }
  return std::sqrt(error / norm);
}

Frame render_once(const SharedScene& shared, const std::string& name, const std::map<std::string, std::string>& given,
                  const GBuffer& view) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given))->render(view);
}

/// Every `step`-th point of the view.
GBuffer thinned(const GBuffer& view, std::size_t step) {
  GBuffer some{view.width, view.height, {}, {}};
  for (std::size_t i = 0; i < view.points.size(); i += step) some.points.push_back(view.points[i]);
  return some;
}

bool same_for_one_thread(const Scene& scene, const SharedSettings& settings, const Frame& frame) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const SharedScene shared(scene, settings);
  return render_once(shared, "hierarchical", {}, shared.view).exitance == frame.exitance;
}

/// A sphere of whole milk, lit from the side; about 1e5 visible points.
struct Ball {
  Scene scene;
  SharedScene shared;
  ClusterTree tree;
  ChannelProfiles profiles;
  std::vector<glm::vec3> points, some;  ///< all, and every tenth
  std::vector<glm::vec3> exact;         ///< at every hundredth
  float floor = 0;

  explicit Ball(std::size_t samples)
      : scene(make()),
        shared(scene, {samples, {}}),
        tree(build_cluster_tree(shared.cells[0], shared.irradiance[0])),
        profiles(*find_profile("standard_dipole"), scene.materials[0], 1.01 * diameter(scene.objects[0].mesh)) {
    std::vector<glm::vec3> few;
    for (std::size_t i = 0; i < shared.view.points.size(); ++i) {
      points.push_back(shared.view.points[i].position);
      if (i % 10 == 0) some.push_back(points.back());
      if (i % 100 == 0) few.push_back(points.back());
    }
    floor = 1e-3f * static_cast<float>(tree.total_mass[0]) / tree.nodes.front().area;
    exact = gather(few, {GatherSettings::Criterion::error, 1e-5, 0});
  }

  static Scene make() {
    SceneChoice choice;
    choice.film = 393, choice.height = 20;
    Scene scene = bench_scene(choice);
    scene.objects[0].mesh = make_sphere(10, 20000);
    scene.camera.type = Camera::Type::orthographic;
    scene.camera.height = 22;
    return scene;
  }
  std::vector<glm::vec3> gather(std::span<const glm::vec3> at, const GatherSettings& settings,
                                Counters* counters = nullptr) const {
    Counters ignored;
    return gather_exitance(tree, shared.cells[0], profiles, shared.irradiance[0].colour, at, settings,
                           counters ? *counters : ignored);
  }
  /// Relative, RMS over points and channels that are not dark; got: at every `step`-th of what `exact` skips.
  double rms(const std::vector<glm::vec3>& got, std::size_t step) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < exact.size(); ++i)
      for (int c = 0; c < 3; ++c)
        if (exact[i][c] > floor)
          sum += std::pow(static_cast<double>(got[i * step][c]) / static_cast<double>(exact[i][c]) - 1, 2), ++count;
    return std::sqrt(sum / count);
  }
};

struct Reached {
  double microseconds = 0, rms = 0;
  std::string note;
};

/// The loosest of `settings` (loose to tight) whose error is small enough.
Reached reach(const Ball& ball, double rms, bool all_points, int runs, const std::vector<GatherSettings>& settings) {
  const std::vector<glm::vec3>& points = all_points ? ball.points : ball.some;
  Reached r;
  for (const GatherSettings& s : settings) {
    Counters counters;
    r.rms = ball.rms(ball.gather(points, s, &counters), all_points ? 100 : 10);
    if (r.rms > rms) continue;
    const auto n = static_cast<double>(points.size());
    r.microseconds = 1e6 / n * median_seconds(runs, [&] { ball.gather(points, s); });
    r.note = fmt::format(
        "rms {:.1e}; {:.0f} patches, {:.0f} nodes judged a query", r.rms,
        static_cast<double>(counters.done["clusters"] + counters.done["cells"] + counters.done["cell_parts"]) / n,
        static_cast<double>(counters.done["nodes_visited"]) / n);
    break;
  }
  return r;
}

std::vector<GatherSettings> ladder(GatherSettings::Criterion criterion) {
  std::vector<GatherSettings> all;
  for (double t = 3; t > 5e-6; t /= 1.8)
    all.push_back(criterion == GatherSettings::Criterion::solid_angle ? GatherSettings{criterion, 0, t}
                                                                      : GatherSettings{criterion, t, 0});
  return all;
}

}  // namespace

std::vector<Figure> sphere_figures(int runs) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  std::vector<Figure> figures;
  const struct { double rms, asked, ratio; } goals[] = {{1e-2, 0.5, 20}, {1e-3, 0.8, 80}, {1e-4, 2.5, 0}};
  double at_loose = 0;
  for (const std::size_t samples : {100000, 1000000}) {
    const Ball ball(samples);
    const double build =
        median_seconds(runs, [&] { build_cluster_tree(ball.shared.cells[0], ball.shared.irradiance[0]); });
    figures.push_back(
        {fmt::format("{} samples: tree", samples), 1e3 * build, samples > 100000 ? 300.0 : 0, true, "ms",
         fmt::format("{:.0f} bytes a sample", static_cast<double>(ball.tree.bytes()) / static_cast<double>(samples))});
    for (const auto& goal : goals) {
      const Reached r = reach(ball, goal.rms, true, runs, ladder(GatherSettings::Criterion::error));
      const double asked = samples == 100000 ? goal.asked : goal.rms == 1e-2 ? 1.5 * at_loose : 0;
      figures.push_back({fmt::format("{} samples, rms {:.0e}: one core", samples, goal.rms), r.microseconds, asked,
                         true, "us/query", r.note});
      if (goal.rms == 1e-2) at_loose = r.microseconds;
      if (samples > 100000 || goal.ratio == 0) continue;
      const Reached p = reach(ball, goal.rms, false, 1, ladder(GatherSettings::Criterion::solid_angle));
      figures.push_back({"  published criterion over it, at equal rms", p.microseconds / r.microseconds, goal.ratio,
                         false, "", fmt::format("{:.1f} us/query, {}", p.microseconds, p.note)});
    }
  }
  return figures;
}

std::vector<Figure> render_figures(const SceneChoice& choice) {
  const Scene scene = bench_scene(choice);
  const SharedSettings settings{choice.samples, {}};
  const double shared_seconds = median_seconds(choice.runs, [&] { const SharedScene shared(scene, settings); });
  const SharedScene shared(scene, settings);
  const double points = static_cast<double>(shared.view.points.size());
  const std::size_t step = std::max<std::size_t>(1, shared.view.points.size() / 1000);
  const Frame oracle = render_once(shared, "brute_force", {}, thinned(shared.view, step));
  std::vector<Figure> figures = {{"object pixels", points, 0, true, "", ""},
                                 {"G-buffer, surface cells and irradiance", shared_seconds, 0, true, "s", ""}};
  Frame default_frame;
  const auto measure = [&](const std::string& label, const std::map<std::string, std::string>& given, double asked) {
    Frame frame;
    const double seconds =
        median_seconds(choice.runs, [&] { frame = render_once(shared, "hierarchical", given, shared.view); });
    figures.push_back(
        {"hierarchical, " + label + ": tree and picture", seconds, 0, true, "s",
         fmt::format("{:.0f} clusters a query{}", static_cast<double>(frame.counters.done["clusters"]) / points,
                     frame.estimates.count("discretisation_error")
                         ? fmt::format(", cells wrong by {:.1e} (estimated)", frame.estimates["discretisation_error"])
                         : "")});
    figures.push_back({"  error against brute_force (rms)", rms_error(frame, oracle, step), 0, true, "", ""});
    if (asked > 0) {
      figures.push_back({"  whole picture from the loaded scene", seconds + shared_seconds, asked, true, "s", ""});
      default_frame = frame;
    }
  };
  measure("tolerance 1e-3 for clusters and cells", {}, 1.5);
  measure("1e-3, cells as given", {{"discretisation", "fixed"}}, 0);
  measure("1e-2, cells as given", {{"max_relative_error", "1e-2"}, {"discretisation", "fixed"}}, 0);
  measure("1e-4, cells as given", {{"max_relative_error", "1e-4"}, {"discretisation", "fixed"}}, 0);
  measure("solid angle 0.2, as published", {{"criterion", "solid_angle"}}, 0);
  measure("solid angle 0.02, as published", {{"criterion", "solid_angle"}, {"quality", "0.02"}}, 0);
  figures.push_back({"pixels that differ with one thread (0: same picture)",
                     same_for_one_thread(scene, settings, default_frame) ? 0.0 : 1.0, 0.5, true, "", ""});
  return figures;
}

}  // namespace opaline::bench
