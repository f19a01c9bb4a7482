// Layered convolution: error against layers, and what every skip saves, as ratios of processor time in one run.
#include "datasets_synthetic/shapes/shapes.h"
#include "render/gl/context.h"
#include "render/input_error.h"
#include "render/techniques/technique.h"
#include "validate/bench/figures.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline::bench {
namespace {

using Given = std::map<std::string, std::string>;

constexpr int film = 800;

Scene layered_scene(SceneChoice choice, const std::string& material, double height, int pixels) {
  choice.material = material, choice.height = height, choice.film = pixels;
  Scene scene = bench_scene(choice);
  scene.lights = {DirectionalLight{glm::normalize(glm::dvec3(-0.4, -0.2, -0.9)), Rgb(pi), 0}};
  return scene;
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const std::string& name, const Given& given) {
  const Technique& technique = find_technique(name);
  return technique.prepare(shared, Settings(technique.settings, given));
}

double rms_error(const Frame& frame, const Frame& reference) {
  double error = 0, norm = 0;
  for (std::size_t i = 0; i < reference.exitance.size(); ++i) {
    const glm::dvec3 r(reference.exitance[i]), d = glm::dvec3(frame.exitance[i]) - r;
    error += glm::dot(d, d), norm += glm::dot(r, r);
  }
  return std::sqrt(error / norm);
}

/// The paper's settings: nothing skipped, whole resolution, half to each layer, everything between layers.
Given plain() {
  return {{"mode", "given"},     {"layers", "8"},           {"splat", "half"},       {"near", "layers"},
          {"threshold", "0"},    {"resolution", "100"},     {"dark_layers", "keep"}, {"unseen_layers", "keep"},
          {"rectangle", "film"}, {"equal_channels", "each"}};
}

Given plain(const Given& changed) {
  Given given = plain();
  for (const auto& [key, value] : changed) given[key] = value;
  return given;
}

/// The defaults but for layers picked by hand.
Given fast(const std::string& layers) { return {{"mode", "given"}, {"layers", layers}}; }

struct Run {
  Frame frame;
  double seconds;  ///< of the processor, on all threads
};

Run run(const SharedScene& shared, const Given& given, int runs) {
  const auto prepared = prepare(shared, "layered_convolution", given);
  Run r;
  r.seconds = median_processor_seconds(runs, [&] { r.frame = prepared->render(shared.view); });
  return r;
}

void print_errors(const SceneChoice& choice, const std::string& material) {
  const Scene scene = layered_scene(choice, material, choice.height, 400);
  const SharedScene shared(scene, {choice.samples, {}});
  const Frame reference = prepare(shared, "hierarchical", {})->render(shared.view);
  for (const char* near : {"layers", "surface"})
    for (const char* splat : {"half", "linear"}) {
      fmt::print("{:<11}{:<9}{:<7}", material, near, splat);
      for (const char* layers : {"2", "4", "8", "16", "32"}) {
        Given given = fast(layers);
        given["near"] = near, given["splat"] = splat;
        fmt::print("{:>9.4f}",
                   rms_error(prepare(shared, "layered_convolution", given)->render(shared.view), reference));
      }
      fmt::print("\n");
    }
}

void print_ratio(const std::string& name, const Run& without, const Run& with, const std::string& paper) {
  const auto count = [](const Run& r, const char* what) { return r.frame.counters.done.at(what); };
  fmt::print("{:<44}{:>8.2f}{:>8.2f}{:>8.2f}x  {:>5} -> {:<6}{:>5} -> {:<6}{:>10.1e}   {}\n", name, without.seconds,
             with.seconds, without.seconds / with.seconds, count(without, "convolutions"), count(with, "convolutions"),
             count(without, "transforms"), count(with, "transforms"), rms_error(with.frame, without.frame), paper);
}

void print_ratios(const SceneChoice& choice) {
  const int runs = 1;
  for (const double height : {0.1 * choice.height, choice.height}) {
    const Scene scene = layered_scene(choice, "wholemilk", height, film);
    const SharedScene shared(scene, {choice.samples, {}});
    const Run none = run(shared, plain(), runs);
    const std::string size = fmt::format("{:.3g} mm: ", height);
    print_ratio(size + "threshold .1 %", none, run(shared, plain({{"threshold", "1e-3"}}), runs),
                height < choice.height ? "7 of 8 per layer" : "1 of 8 per layer, 26 s -> 5 s");
    print_ratio(size + "resolution 50 %", none, run(shared, plain({{"resolution", "50"}}), runs), "4.4x");
    print_ratio(size + "resolution 25 %", none, run(shared, plain({{"resolution", "25"}}), runs), "15x");
    print_ratio(size + "unseen layers", none, run(shared, plain({{"unseen_layers", "skip"}}), runs), "about 2x");
    print_ratio(size + "dark layers", none, run(shared, plain({{"dark_layers", "skip"}}), runs), "");
    print_ratio(size + "bounding rectangle", none, run(shared, plain({{"rectangle", "object"}}), runs), "");
    Given all = fast("8");
    all["splat"] = "half", all["near"] = "layers";
    print_ratio(size + "all", none, run(shared, all, runs), "");
  }
  // Of a ball half of the layers are seen.
  Scene scene = layered_scene(choice, "wholemilk", choice.height, film);
  scene.objects[0].mesh = make_sphere(choice.height / 2, 20000);
  const SharedScene shared(scene, {choice.samples, {}});
  print_ratio("a ball: unseen layers", run(shared, plain(), runs),
              run(shared, plain({{"unseen_layers", "skip"}}), runs), "about 2x");
}

void gpu_figures(const SharedScene& shared, const SceneChoice& choice, std::vector<Figure>& figures) {
  const Technique& technique = find_technique("layered_convolution");
  try {
    const auto context = gl::Context::create();
    const auto prepared = technique.prepare_gpu(shared, Settings(technique.settings, fast("8")), *context);
    figures.push_back({"gpu: 8 layers, processor time of all threads",
                       1e3 * median_processor_seconds(choice.runs, [&] { prepared->render(shared.view); }), 0, true,
                       "ms", context->info().description()});
  } catch (const MachineError& error) {
    fmt::print("gpu left out: {}\n", error.what());
  }
}

std::vector<Figure> time_figures(const SceneChoice& choice) {
  const Scene scene = layered_scene(choice, "wholemilk", choice.height, film);
  const SharedScene shared(scene, {choice.samples, {}});
  const Frame reference = prepare(shared, "hierarchical", {})->render(shared.view);
  const Run eight = run(shared, fast("8"), choice.runs);
  std::vector<Figure> figures = {
      {"8 layers, all skips: processor time of all threads", 1e3 * eight.seconds, 500, true, "ms",
       "two idle cores: half of it"},
      {"  error against the reference (relative rms)", rms_error(eight.frame, reference), 0.02, true, "", ""}};
  const Run picked = run(shared, {}, 1);
  figures.push_back({"wanted_error .02: processor time of all threads", 1e3 * picked.seconds, 0, true, "ms",
                     picked.frame.notes.front()});
  figures.push_back(
      {"  error against the reference (relative rms)", rms_error(picked.frame, reference), 0.02, true, "", ""});
  gpu_figures(shared, choice, figures);
  return figures;
}

}  // namespace

void print_layered_figures(const SceneChoice& choice) {
  print_figures(fmt::format("Layered convolution: whole milk, {} x {} pixels", film, film), time_figures(choice));
  fmt::print(
      "\nRelative RMS error against the hierarchical reference, front-lit, 400 x "
      "400\n{:<27}{:>9}{:>9}{:>9}{:>9}{:>9}\n",
      "material   near     splat", "2 layers", "4", "8", "16", "32");
  for (const char* material : {"wholemilk", "apple", "marble", "skimmilk", "ketchup"}) print_errors(choice, material);
  fmt::print(
      "\nSkips, each against none: 8 layers of whole milk, splat=half, near=layers, {} x {}; processor seconds\n"
      "{:<44}{:>8}{:>8}{:>9}  {:<16}{:<16}{:>7}   {}\n",
      film, film, "", "without", "with", "ratio", "convolutions", "transforms", "change", "the paper's");
  print_ratios(choice);
}

}  // namespace opaline::bench
