// Subsurface texture mapping: time of a frame on both backends, frame-time ratios beside the paper's, and its error
// against exact single scattering: what the march leaves and what the planes leave.
#include "validate/bench/figures.h"

#include "datasets_synthetic/layered/layered_datasets.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "render/gl/context.h"
#include "render/input_error.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

namespace opaline::bench {
namespace {

using Given = std::map<std::string, std::string>;

Scene dataset_scene(const std::string& name) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("opaline-bench-{}-{}", ::getpid(), name);
  write_layered_dataset(*find_layered_dataset(name), folder.string());
  Scene scene = load_scene((folder / "scene.json").string(), synthetic_shapes());
  std::filesystem::remove_all(folder);
  return scene;
}

Frame render(const SharedScene& shared, const std::string& name, const Given& given) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given))->render(shared.view);
}

double relative_rmse(const Frame& frame, const Frame& exact) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < exact.radiance.size(); ++i) {
    const glm::dvec3 b(exact.radiance[i]), d = glm::dvec3(frame.radiance[i]) - b;
    squares += glm::dot(d, d), norm += glm::dot(b, b);
  }
  return std::sqrt(squares / norm);
}

Given steps(const char* n, const char* shadows = "traced") { return {{"samples_per_pixel", n}, {"shadows", shadows}}; }

void time_figures(const Scene& scene, int runs, std::vector<Figure>& figures) {
  const Technique& technique = find_technique("subsurface_texture");
  const SharedScene shared(scene, {1, {}}, false);
  const auto seconds = [&](const Given& given) {
    const auto prepared = technique.prepare(shared, Settings(technique.settings, given));
    return median_seconds(runs, [&] { prepared->render(shared.view); });
  };
  const std::string note = fmt::format("{} object pixels", shared.view.points.size());
  const double at_50 = seconds(steps("50", "off"));
  figures.push_back({"cpu: a frame, 800 x 600, N = 50, three lights", 1e3 * at_50, 250, true, "ms", note});
  figures.push_back({"  with traced shadows", 1e3 * seconds(steps("50")), 0, true, "ms", ""});
  figures.push_back({"  N = 10: frames per frame of N = 50", at_50 / seconds(steps("10", "off")), 126.0 / 51, false, "",
                     "paper: 126 / 51"});
  figures.push_back({"  N = 100", at_50 / seconds(steps("100", "off")), 20.0 / 51, false, "", "paper: 20 / 51"});
  try {
    const auto context = gl::Context::create();
    const auto prepared = technique.prepare_gpu(shared, Settings(technique.settings, steps("50", "off")), *context);
    figures.push_back({"gpu: a frame, 800 x 600, N = 50, three lights, after warm-up",
                       1e3 * median_seconds(runs, [&] { prepared->render(shared.view); }), 500, true, "ms",
                       context->info().description()});
  } catch (const MachineError& error) {
    fmt::print("gpu left out: {}\n", error.what());
  }
}

/// Against exact single scattering without refraction; and the march alone, against its own limit.
void print_errors(Scene scene, const std::string& what) {
  scene.film = {64, 48};
  const SharedScene shared(scene, {1, {}}, false);
  const Frame exact = render(shared, "single_scatter_exact", {{"max_relative_error", "3e-3"}}),
              limit = render(shared, "subsurface_texture", steps("1000")),
              hundred = render(shared, "subsurface_texture", steps("100"));
  std::string row, march;
  for (const char* n : {"10", "20", "50", "100"}) {
    const Frame frame = render(shared, "subsurface_texture", steps(n));
    row += fmt::format("{:>9.4f}", relative_rmse(frame, exact));
    march += fmt::format("{:>9.4f}", relative_rmse(frame, limit));
  }
  fmt::print("{:<34}{}   planes alone (N = 1000) {:.4f}\n{:<34}{}   50 against 100 {:.5f}\n", what, row,
             relative_rmse(limit, exact), "  the march alone", march,
             relative_rmse(render(shared, "subsurface_texture", steps("50")), hundred));
}

Scene only_light(Scene scene, std::size_t light) {
  scene.lights = {scene.lights[light]};
  return scene;
}

}  // namespace

void print_subsurface_figures(const SceneChoice& choice) {
  const char* media[] = {"fish_layers", "head_veins"};
  for (const char* name : media) {
    std::vector<Figure> figures;
    time_figures(dataset_scene(name), choice.runs, figures);
    print_figures(fmt::format("Subsurface texture mapping: {}", name), figures);
  }
  fmt::print("\nRelative RMS error against single_scatter_exact (no refraction), 64 x 48\n{:<34}{:>9}{:>9}{:>9}{:>9}\n",
             "", "N = 10", "20", "50", "100");
  for (const char* name : media) {
    const Scene scene = dataset_scene(name);
    print_errors(scene, name);
    print_errors(only_light(scene, 0), std::string(name) + ", light in front alone");
    print_errors(only_light(scene, 2), std::string(name) + ", light behind alone");
  }
}

}  // namespace opaline::bench
