// Is every material of the library recovered from a noise-free picture of the reference, or refused for the right
// reason? The right reason is the Cramer-Rao bound's: a parameter that the picture determines to 1e-3 with noise as
// large as the operator's own error must come back to 1e-3; one that it does not must be called so.
#include "datasets_synthetic/shapes/shapes.h"
#include "fit/diagnosis.h"
#include "fit/profile_interval.h"
#include "fit/rendered_reference.h"
#include "model/materials/library.h"
#include "render/render_scene.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline::bench {
namespace {

const ProfileInfo& transport() { return *find_profile("transport_table"); }

Scene scene_of(const std::string& shape, const std::string& mesh) {
  SceneChoice choice;
  choice.film = 24;
  if (shape == "mesh") choice.mesh = mesh;
  Scene scene = bench_scene(choice);
  if (shape == "sphere") scene.objects.front().mesh = make_sphere(15, 5000);
  if (shape == "slab") {
    scene.objects.front().mesh = make_slab({60, 60, 30}, 20000);
    scene.camera.type = Camera::Type::orthographic;
    scene.camera.position = {0, 0, 20}, scene.camera.look_at = {0, 0, 0}, scene.camera.height = 20;
    ProjectorLight beam;
    beam.position = {0, 0, 100}, beam.intensity = Rgb(3e4), beam.disk_radius_deg = 1.43;
    scene.lights = {beam};
  }
  return scene;
}

struct Outcome {
  double worst = 0;  ///< relative error of what the fit calls identifiable
  std::string worst_of, not_identifiable, reason;
  bool converged = false;
  double before = 0;  ///< worst relative error of any parameter without correction
  int renders = 0;
};

double worst_error(const ParameterVector& found, const ParameterVector& truth) {
  double worst = 0;
  for (int i = 0; i < parameter_count; ++i) {
    const auto at = static_cast<std::size_t>(i);
    worst = std::max(worst, std::abs(natural_value(i, found[at]) / natural_value(i, truth[at]) - 1));
  }
  return worst;
}

Outcome recover(const Scene& scene, const TransportOperator& op, std::size_t samples) {
  RenderOptions options;
  options.technique = "hierarchical";
  options.settings = {{"profile", "transport_table"}, {"max_relative_error", "1e-5"}, {"discretisation", "fixed"}};
  options.shared.samples = samples;
  const Material& truth = scene.materials.front();
  std::vector<FitTarget> targets;
  targets.push_back(make_target(op, render_scene(scene, options).image, "picture"));
  Material start;
  start.sigma_a = Rgb(0.05), start.sigma_s_prime = Rgb(1), start.eta = 1.35;
  const SolveSettings settings;
  Outcome out;
  Solution s = solve(targets, transport(), start, settings);
  const ParameterVector at = to_parameters(truth, s.bounds);
  out.before = worst_error(s.parameters, at);
  const std::vector<TargetScene> scenes = {{std::make_shared<const Scene>(scene), 0}};
  const Correction correction = correct_by_reference(
      targets, transport(), start, settings, rendered_reference(scenes, targets, start, settings.free, options), {}, s);
  out.renders = correction.renders;
  Uncertainty u = uncertainty(s, settings.free);
  profile_intervals(FitProblem(targets, s.whitened, transport(), settings, s.bounds), s, u);
  out.converged = s.converged;
  for (int i = 0; i < parameter_count; ++i) {
    const ParameterEstimate& e = u.parameters[static_cast<std::size_t>(i)];
    if (!e.identifiable) {
      out.not_identifiable += (out.not_identifiable.empty() ? "" : " ") + parameter_name(i);
      if (out.reason.empty()) out.reason = e.reason;
      continue;
    }
    const double error = std::abs(e.value / natural_value(i, at[static_cast<std::size_t>(i)]) - 1);
    if (error > out.worst) out.worst = error, out.worst_of = parameter_name(i);
  }
  return out;
}

}  // namespace

void print_library_figures(const std::string& mesh, std::size_t every, const std::vector<std::string>& shapes) {
  constexpr std::size_t samples = 20000;
  for (const std::string& shape : shapes) {
    Scene scene = scene_of(shape, mesh);
    OperatorSettings settings;
    settings.samples = samples;
    const ParameterBounds bounds;
    const TransportOperator op = build_operator(scene, 0, EtaNodes(bounds.eta_min, bounds.eta_max, 8), settings);
    int recovered = 0, refused = 0, wrong = 0;
    fmt::print(
        "\n| {} | without correction | worst of the identifiable | | renders | not identifiable | reason "
        "|\n|---|---|---|---|---|---|---|\n",
        shape == "mesh" && !mesh.empty() ? mesh
        : shape == "mesh"                ? "bust"
                                         : shape);
    for (std::size_t i = 0; i < material_library().size(); i += every) {
      scene.materials.front() = library_material(material_library()[i].name);
      const Outcome o = recover(scene, op, samples);
      const bool good = o.worst <= 1e-3 && o.converged;
      (!good ? wrong : o.not_identifiable.empty() ? recovered : refused) += 1;
      fmt::print("| {} | {:.1e} | {:.1e} {} | {} | {} | {} | {} |\n", material_library()[i].name, o.before, o.worst,
                 o.worst_of, good ? "" : "WRONG", o.renders, o.not_identifiable, o.reason);
      std::fflush(stdout);
    }
    fmt::print("{}: {} to 1e-3, {} with something not identifiable (the rest to 1e-3), {} wrong\n", shape, recovered,
               refused, wrong);
  }
}

}  // namespace opaline::bench
