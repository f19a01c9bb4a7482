#include "fit/cmd/commands.h"
#include "fit/cmd/fit_arguments.h"
#include "fit/cmd/fit_table.h"
#include "fit/export/export_material.h"
#include "fit/fit_output.h"
#include "render/cmd/exit_status.h"
#include "render/cmd/render_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <memory>

namespace opaline {
namespace {

void run(FitArguments& a, const ShapeLibrary& shapes) {
  complete(a);
  const auto limit = limit_threads(a.threads);
  std::optional<ParameterVector> truth;
  if (!a.truth.empty()) truth = read_truth(a.truth);
  FitReport report;
  {
    ProgressLine progress;
    report = run_fit(a.job, shapes, [&](const std::string& stage) { progress.show(stage); });
  }
  if (truth)
    if (const std::string warning = truth_warning(a.truth, report.job.model); !warning.empty())
      report.uncertainty.notes.push_back(warning);
  const bool usable = report.diagnosis.determined || a.allow_undetermined;
  std::vector<std::string> written = write_fit(report, a.out, usable);
  if (usable) write_exports(report.material, a.exports, a.out, written);
  if (a.json) {
    fmt::print("{}\n", fit_json(report).dump(2));
  } else {
    fmt::print("{}written: {}\n", fit_table(report, truth), fmt::join(written, " "));
  }
  if (!usable) throw CommandFailed(report.diagnosis.refusal);
}

}  // namespace

void add_fit_command(CLI::App& app, const ShapeLibrary& shapes) {
  const auto a = std::make_shared<FitArguments>();
  CLI::App* fit = app.add_subcommand("fit", "Absorption, scattering and refraction index from pictures");
  add_fit_options(*fit, *a);
  fit->footer(
      "Exits with 1, and writes no material.json, if the pictures do not determine a free parameter.\n"
      "Example: opaline fit scene.json --target photo.exr --out result --compare-models --bootstrap 200\n"
      "         opaline fit scene.json --target photo.jpg --transfer srgb --scale free --prior eta=1.4:0.05 --out "
      "result\n"
      "         opaline fit scene.json --target photo.exr --correct-with path_traced --correct-set paths=256 --out "
      "result\n"
      "         opaline fit scene.json --target photo.exr --mask object.png --free sigma_a,sigma_s_prime --out result");
  fit->callback([a, &shapes] { run(*a, shapes); });
}

}  // namespace opaline
