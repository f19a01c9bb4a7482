#include "fit/cmd/commands.h"
#include "fit/cmd/fit_table.h"
#include "fit/fit_output.h"
#include "render/cmd/render_arguments.h"

#include <fmt/format.h>

#include <memory>

namespace opaline {
namespace {

struct Arguments {
  FitJob job;
  std::string free = "sigma_a,sigma_s_prime,eta", out, truth;
  int threads = 0;
  bool json = false;
};

void run(Arguments& a, const ShapeLibrary& shapes) {
  a.job.solve.free = parse_free(a.free);
  const auto limit = limit_threads(a.threads);
  std::optional<ParameterVector> truth;
  if (!a.truth.empty()) truth = read_truth(a.truth);
  ProgressLine progress;
  const FitReport report = run_fit(a.job, shapes, [&](const std::string& stage) { progress.show(stage); });
  const std::vector<std::string> written = write_fit(report, a.out);
  if (a.json) {
    fmt::print("{}\n", fit_json(report).dump(2));
    return;
  }
  fmt::print("{}", fit_table(report, truth));
  fmt::print("written:");
  for (const std::string& path : written) fmt::print(" {}", path);
  fmt::print("\n");
}

void add_inputs(CLI::App& fit, Arguments& a) {
  fit.add_option("SCENE", a.job.scenes, "Scene file: shape, camera, light; one for all targets, or one each")
      ->required();
  fit.add_option("--target", a.job.targets, "Linear picture (EXR) of the scene; may be repeated")
      ->required()
      ->allow_extra_args(false);
  fit.add_option("--mask", a.job.masks, "Image whose first channel is > 0 where pixels count; one for all, or one each")
      ->allow_extra_args(false);
  fit.add_option("--material", a.job.material, "Which material of the scene to fit (default: the only one)");
  fit.add_option("--free", a.free, "What is unknown; the rest stays as in the scene")->capture_default_str();
  fit.add_option("--model", a.job.model, "Diffusion profile")->capture_default_str();
  fit.add_option("--out", a.out, "Folder for fit.json, material.json and pictures; made if missing")->required();
  fit.add_option("--truth", a.truth, "truth.json of a synthetic dataset: adds the true values to the table");
}

void add_numbers(CLI::App& fit, Arguments& a) {
  fit.add_option("--starts", a.job.solve.starts, "Starting points")->check(CLI::Range(1, 1000))->capture_default_str();
  fit.add_option("--samples", a.job.op.samples, "Surface cells over all objects")
      ->check(CLI::Range(1, 100'000'000))
      ->capture_default_str();
  fit.add_option("--light-samples", a.job.op.irradiance.area_samples,
                 "Directions per cell towards disks and environments")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  fit.add_option("--seed", a.job.op.irradiance.seed, "Of the light samples")->capture_default_str();
  add_threads_option(fit, a.threads);
  fit.add_flag("--json", a.json, "Print fit.json instead of the table");
}

}  // namespace

void add_fit_command(CLI::App& app, const ShapeLibrary& shapes) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* fit = app.add_subcommand("fit", "Absorption, scattering and refraction index from pictures");
  add_inputs(*fit, *a);
  add_numbers(*fit, *a);
  fit->footer(
      "Example: opaline fit scene.json --target photo.exr --out result\n"
      "         opaline fit scene.json --target photo.exr --mask object.png --free sigma_a,sigma_s_prime --out result");
  fit->callback([a, &shapes] { run(*a, shapes); });
}

}  // namespace opaline
