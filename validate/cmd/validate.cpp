#include "model/cmd/exit_status.h"
#include "render/cmd/render_arguments.h"
#include "render/scene/json_object.h"
#include "validate/cmd/advice_table.h"
#include "validate/cmd/baseline_table.h"
#include "validate/cmd/commands.h"
#include "validate/cmd/gate_table.h"
#include "validate/cmd/run_table.h"
#include "validate/cmd/supervise.h"
#include "validate/junit.h"
#include "validate/matrix.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace opaline {
namespace {

struct Arguments {
  std::string suite = "quick", gates, junit, baseline;
  std::vector<std::string> externals;
  RunOptions run;
  bool self_check = false, quiet = false;
};

/// A records.jsonl, or the folder that holds one.
std::vector<Record> baseline_records(const std::string& path) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  return read_records(folder ? path + "/records.jsonl" : path).records;
}

RunSummary measure(const Suite& suite, const RunOptions& options, const ShapeLibrary& shapes) {
  ProgressLine progress;
  return run_suite(suite, options, shapes, [&](const std::string& name, std::size_t done, std::size_t of) {
    progress.show(fmt::format("[{}/{}] {}", done + 1, of, name));
  });
}

void self_check(const Suite& suite, RunOptions options, const ShapeLibrary& shapes, const RunSummary& first) {
  options.remeasure = true;
  fmt::print("{}", repeat_table(first, measure(suite, options, shapes)));
}

/// Prints everything, writes everything, and only then fails.
void judge(const Arguments& a, const Suite& suite, const std::vector<Gate>& gates, const std::vector<Record>& before,
           const std::vector<Record>& records) {
  const std::vector<GateResult> results = check_gates(gates, records);
  if (!gates.empty()) {
    fmt::print("{}", gate_table(results));
    write_text_atomically(a.run.folder + "/gates.json", to_json(results).dump(2) + "\n");
  }
  if (!a.junit.empty()) write_text_atomically(a.junit, junit_xml(suite.name, results, records));
  const BaselineComparison comparison = compare_with_baseline(before, records);
  if (!a.baseline.empty()) fmt::print("{}", baseline_table(comparison));
  if (failed_gates(results) > 0) throw CommandFailed(fmt::format("{} gates fell short", failed_gates(results)));
  if (!a.baseline.empty() && comparison.any_worse()) throw CommandFailed("the run is worse than its baseline");
}

void run(Arguments& a, const ShapeLibrary& shapes) {
  check_output_path(a.junit, ".xml");
  for (const std::string& text : a.externals) a.run.choice.externals.push_back(parse_external(text));
  const Suite suite = find_suite(a.suite);
  const std::vector<Gate> gates = a.gates.empty() ? std::vector<Gate>{} : find_gates(a.gates).gates;
  const std::vector<Record> before = a.baseline.empty() ? std::vector<Record>{} : baseline_records(a.baseline);
  supervise(a.run.folder + "/measuring", [&](const std::map<std::string, std::string>& failed) {
    const auto limit = limit_threads(a.run.threads);
    a.run.failed = failed;
    const RunSummary summary = measure(suite, a.run, shapes);
    if (!a.quiet) fmt::print("{}{}", run_table(summary), front_table(summary.records));
    fmt::print("{}", run_totals(suite, a.run, summary));
    if (a.self_check) self_check(suite, a.run, shapes, summary);
    judge(a, suite, gates, before, summary.records);
  });
}

void add_choice(CLI::App& validate, Arguments& a) {
  validate.add_option("--scene", a.run.choice.scenes, "Only this scene; may be repeated")->allow_extra_args(false);
  validate.add_option("--technique", a.run.choice.techniques, "Only this technique; may be repeated")
      ->allow_extra_args(false);
  validate.add_option("--backend", a.run.choice.backends, "Only cpu or gpu")->allow_extra_args(false);
  validate.add_option("--gl", a.run.choice.gl, "GL of the gpu backend: egl or osmesa");
  validate
      .add_option("--external", a.externals,
                  "NAME=COMMAND: another renderer; {scene} and {out} stand for its scene file and EXR")
      ->allow_extra_args(false);
}

}  // namespace

void add_validate_command(CLI::App& app, const ShapeLibrary& shapes) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* validate = app.add_subcommand("validate", "Measures what every technique costs and how wrong it is");
  validate->add_option("SUITE", a->suite, "quick, default, full, or a file that ends in .json")->capture_default_str();
  validate->add_option("--out", a->run.folder, "Folder of the records; what it has already is not measured again")
      ->required();
  add_choice(*validate, *a);
  validate->add_flag("--remeasure", a->run.remeasure, "Measure cells again that have a record");
  validate->add_option("--gates", a->gates, "quick, or a file of limits; exit with 1 when one is broken");
  validate->add_option("--junit", a->junit, "Write gates and cells as JUnit XML");
  validate->add_option("--baseline", a->baseline, "Folder of an earlier run; exit with 1 when this one is worse");
  validate->add_flag("--self-check", a->self_check, "Measure everything twice and report how far the times differ");
  validate->add_flag("--quiet", a->quiet, "Only totals and verdicts, no table of cells");
  add_threads_option(*validate, a->run.threads);
  validate->footer("Example: opaline validate quick --out out/quick --gates quick --junit out/quick.xml");
  validate->callback([a, &shapes] { run(*a, shapes); });
}

}  // namespace opaline
