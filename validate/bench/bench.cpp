// `./run bench`: the figures the project asks of itself, measured on this machine. Times are medians
// within one run; compare ratios, not machines.
#include "render/input_error.h"
#include "validate/bench/figures.h"

#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace opaline::bench {
void register_kernels();

namespace {

void run_kernels() {
  register_kernels();
  std::string program = "opaline_bench", minimum = "--benchmark_min_time=0.2";
  char* arguments[] = {program.data(), minimum.data()};
  int count = 2;
  benchmark::Initialize(&count, arguments);
  benchmark::RunSpecifiedBenchmarks();
}

int run(int argc, char** argv) {
  SceneChoice choice;
  ModelChoice model_choice;
  bool kernels = true, model = true, gather = true, render = true, paths = true, fit = true, image_space = true;
  bool layers = true, subsurface = true, transfer = true;
  int repetitions = 0;
  bool examination = false;
  std::size_t library = 0;
  std::vector<std::string> library_shapes = {"sphere", "mesh", "slab"};
  CLI::App app("Opaline's benchmark: figures reached beside figures asked", "opaline_bench");
  app.add_option("--mesh", choice.mesh, "Mesh file instead of the synthetic bust");
  app.add_option("--height", choice.height, "Of the object [mm]")->check(CLI::PositiveNumber)->capture_default_str();
  app.add_option("--material", choice.material, "From the library")->capture_default_str();
  app.add_option("--film", choice.film, "Pixels a side")->check(CLI::Range(16, 4096))->capture_default_str();
  app.add_option("--samples", choice.samples, "Surface cells")->capture_default_str();
  app.add_option("--runs", choice.runs, "Timed runs, of which the median counts")
      ->check(CLI::Range(1, 101))
      ->capture_default_str();
  app.add_flag("!--no-kernels", kernels, "Leave out the inner loops");
  app.add_option("--walks", model_choice.walks, "Monte-Carlo walks per row of the transport check (full: 100000000)")
      ->check(CLI::Range(std::uint64_t{1000}, std::uint64_t{100000000000}))
      ->capture_default_str();
  app.add_option("--sampler-samples", model_choice.samples, "Samples per chi-squared test")
      ->check(CLI::Range(std::uint64_t{10000}, std::uint64_t{100000000000}))
      ->capture_default_str();
  app.add_flag("!--no-model", model, "Leave out sampling and Monte-Carlo");
  app.add_flag("!--no-gather", gather, "Leave out the gather on a sphere");
  app.add_flag("!--no-render", render, "Leave out the renderer");
  app.add_flag("!--no-paths", paths, "Leave out the path tracer");
  app.add_flag("!--no-fit", fit, "Leave out the fit");
  app.add_flag("!--no-image-space", image_space, "Leave out image-space sampling");
  app.add_flag("!--no-layers", layers, "Leave out layered convolution");
  app.add_flag("!--no-subsurface", subsurface, "Leave out subsurface texture mapping");
  app.add_flag("!--no-transfer", transfer, "Leave out precomputed transfer");
  app.add_option("--transfer-vertices", choice.transfer_vertices, "Of precomputed transfer's teapot, about")
      ->check(CLI::Range(std::size_t{200}, std::size_t{10000000}))
      ->capture_default_str();
  app.add_option("--calibration", repetitions,
                 "Repetitions of noisy fits, 500 for the figures asked (a minute; 0: none)")
      ->check(CLI::Range(0, 100000));
  app.add_flag("--examination", examination, "Two views of 512 x 512: models compared, bootstrap");
  app.add_option("--library", library,
                 "Every N-th material of the library from a noise-free picture (1: all, an hour; 0: none)")
      ->check(CLI::Range(std::size_t{0}, std::size_t{1000}));
  app.add_option("--library-shapes", library_shapes, "What the library is fitted on")
      ->delimiter(',')
      ->check(CLI::IsMember({"sphere", "mesh", "slab"}))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  fmt::print("{}\n", machine());
  if (kernels) {
    run_kernels();
    print_figures("Kernels on one core", kernel_figures());
  }
  if (model) print_figures("Model: sampling and Monte-Carlo", model_figures(model_choice));
  const std::string title =
      fmt::format("{} of {}, {} mm high, {} x {} pixels, {} cells", choice.mesh.empty() ? "bust" : choice.mesh,
                  choice.material, choice.height, choice.film, choice.film, choice.samples);
  if (gather) print_figures("Gather: 1e5 points of a sphere, whole milk, one core", sphere_figures(choice.runs));
  if (render) print_figures("Renderer: " + title, render_figures(choice));
  if (image_space) print_image_space_figures(choice);
  if (layers) print_layered_figures(choice);
  if (subsurface) print_subsurface_figures(choice);
  if (transfer) print_transfer_figures(choice);
  if (paths) print_figures("Transport, 64 x 64 pixels, " + choice.material, path_figures(choice));
  if (fit) print_figures("Fit: " + title, fit_figures(choice));
  if (examination) print_figures("Examination of a large fit: " + title, examination_figures(choice));
  if (repetitions > 0)
    print_figures("Calibration of the fit, 40 x 40 pixels", calibration_figures(repetitions, choice.mesh));
  if (library > 0) print_library_figures(choice.mesh, library, library_shapes);
  return 0;
}

}  // namespace
}  // namespace opaline::bench

int main(int argc, char** argv) {
  try {
    return opaline::bench::run(argc, argv);
  } catch (const opaline::InputError& error) {
    std::fprintf(stderr, "opaline_bench: %s\n", error.what());
    return 2;
  }
}
