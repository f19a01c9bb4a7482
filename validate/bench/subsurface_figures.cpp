// Subsurface texture mapping: time of a frame on both backends, frame-time ratios beside the paper's, and its error
// against exact single scattering: what the march leaves and what the planes leave, and where light comes through thin
// parts.
#include "validate/bench/figures.h"

#include "datasets_synthetic/layered/layered_datasets.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "model/simd.h"
#include "render/gl/context.h"
#include "render/input_error.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

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

/// Of the pixels that `counts` takes, all if it is empty.
double relative_rmse(const Frame& frame, const Frame& exact, const std::vector<bool>& counts = {}) {
  double squares = 0, norm = 0;
  for (std::size_t i = 0; i < exact.radiance.size(); ++i) {
    if (!counts.empty() && !counts[i]) continue;
    const glm::dvec3 b(exact.radiance[i]), d = glm::dvec3(frame.radiance[i]) - b;
    squares += glm::dot(d, d), norm += glm::dot(b, b);
  }
  return std::sqrt(squares / norm);
}

Given steps(const char* n, const char* shadows = "traced") { return {{"samples_per_pixel", n}, {"shadows", shadows}}; }

using Prepare = std::function<std::unique_ptr<PreparedTechnique>(const Given&)>;

/// Processor seconds of frames of N = 10, 50 and 100, and what they say beside the paper's frame rates.
double ratio_figures(const std::string& backend, const SharedScene& shared, const Prepare& prepare, int runs,
                     std::vector<Figure>& figures) {
  const auto seconds = [&](const char* n) {
    const auto prepared = prepare(steps(n, "off"));
    return median_processor_seconds(runs, [&] { prepared->render(shared.view); });
  };
  const double at_50 = seconds("50");
  figures.push_back({backend + ": frames at N = 10 per frame at N = 50", at_50 / seconds("10"), 126.0 / 51, false, "",
                     "paper: 126 / 51 on the fish, 120 / 33 on the gecko"});
  figures.push_back({backend + ": frames at N = 100 per frame at N = 50", at_50 / seconds("100"), 20.0 / 51, false, "",
                     "paper: 20 / 51 and 16 / 33"});
  return at_50;
}

void add_time(const std::string& backend, const SharedScene& shared, const Prepare& prepare, int runs, double asked,
              const std::string& note, std::vector<Figure>& figures) {
  const auto prepared = prepare(steps("50", "off"));
  figures.push_back({backend + ": a frame, 800 x 600, N = 50, three lights",
                     1e3 * median_seconds(runs, [&] { prepared->render(shared.view); }), asked, true, "ms", note});
  const double at_50 = ratio_figures(backend, shared, prepare, runs, figures);
  figures.push_back({backend + ": its processor time over two", 1e3 * at_50 / 2, asked, true, "ms",
                     "what two idle cores take at best"});
}

void time_figures(const Scene& scene, int runs, std::vector<Figure>& figures) {
  const Technique& technique = find_technique("subsurface_texture");
  const SharedScene shared(scene, {1, {}}, false);
  const Prepare cpu = [&](const Given& given) {
    return technique.prepare(shared, Settings(technique.settings, given));
  };
  const auto seconds = [&](const Given& given) {
    const auto prepared = cpu(given);
    return median_processor_seconds(runs, [&] { prepared->render(shared.view); });
  };
  add_time("cpu", shared, cpu, runs, 250, fmt::format("{} object pixels", shared.view.points.size()), figures);
  const double best = seconds(steps("50", "off"));
  figures.push_back({"cpu: with traced shadows, over without", seconds(steps("50")) / best, 0, true, "", ""});
  for (const std::string& target : simd_targets()) {
    limit_simd_target(target);
    figures.push_back(
        {fmt::format("cpu: {} over the best", target), seconds(steps("50", "off")) / best, 0, true, "", ""});
  }
  limit_simd_target("");
  try {
    const auto context = gl::Context::create();
    const Prepare gpu = [&](const Given& given) {
      return technique.prepare_gpu(shared, Settings(technique.settings, given), *context);
    };
    add_time("gpu", shared, gpu, runs, 500, context->info().description(), figures);
  } catch (const MachineError& error) {
    fmt::print("gpu left out: {}\n", error.what());
  }
}

/// Where the object is thinner than that along the view [mm].
std::vector<bool> thin_pixels(const SharedScene& shared, float thickness) {
  std::vector<bool> thin;
  for (const VisiblePoint& p : shared.view.points) {
    const SurfaceHit far = shared.rays.closest(p.position, -p.w_o, shared.rays.offset());
    thin.push_back(far.object >= 0 && far.distance < thickness);
  }
  return thin;
}

/// Against exact single scattering without refraction; and the march alone, against its own limit.
void print_errors(Scene scene, const std::string& what, int height) {
  scene.film = {height * 4 / 3, height};
  const SharedScene shared(scene, {1, {}}, false);
  const Frame exact = render(shared, "single_scatter_exact", {{"max_relative_error", "3e-3"}}),
              limit = render(shared, "subsurface_texture", steps("1000"));
  std::map<std::string, Frame> frames;
  std::string row, march;
  for (const char* n : {"10", "20", "50", "100"}) {
    frames[n] = render(shared, "subsurface_texture", steps(n));
    row += fmt::format("{:>9.4f}", relative_rmse(frames[n], exact));
    march += fmt::format("{:>9.5f}", relative_rmse(frames[n], limit));
  }
  const std::vector<bool> thin = thin_pixels(shared, 3);
  fmt::print("{:<34}{}   planes alone (N = 1000) {:.4f}\n{:<34}{}   50 against 100 {:.5f}\n", what, row,
             relative_rmse(limit, exact), "  the march alone", march, relative_rmse(frames["50"], frames["100"]));
  if (const auto count = std::count(thin.begin(), thin.end(), true); count > 0)
    fmt::print("  of {} pixels, the {} less than 3 mm thick: {:.4f}\n", thin.size(), count,
               relative_rmse(frames["50"], exact, thin));
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
  constexpr int height = 36;
  fmt::print("\nRelative RMS error against single_scatter_exact (no refraction), {} x {}\n{:<34}{:>9}{:>9}{:>9}{:>9}\n",
             height * 4 / 3, height, "", "N = 10", "20", "50", "100");
  for (const char* name : media) {
    const Scene scene = dataset_scene(name);
    print_errors(scene, name, height);
    print_errors(only_light(scene, 0), std::string(name) + ", light in front alone", height);
    print_errors(only_light(scene, 1), std::string(name) + ", light from the side alone", height);
    print_errors(only_light(scene, 2), std::string(name) + ", light behind alone", height);
  }
}

}  // namespace opaline::bench
