#include "render/cmd/render_arguments.h"
#include "validate/cmd/advice_table.h"
#include "validate/cmd/commands.h"
#include "validate/cmd/judge.h"
#include "validate/cmd/run_table.h"
#include "validate/cmd/supervise.h"
#include "validate/matrix.h"

#include <fmt/format.h>

#include <memory>

namespace opaline {
namespace {

struct Arguments {
  std::string suite = "quick";
  JudgeOptions judge;
  std::vector<std::string> externals;
  RunOptions run;
  bool self_check = false, quiet = false;
};

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

void run(Arguments& a, const ShapeLibrary& shapes) {
  check_output_path(a.judge.junit, ".xml");
  for (const std::string& text : a.externals) a.run.choice.externals.push_back(parse_external(text));
  const Suite suite = find_suite(a.suite);
  const Judge judge(a.judge);
  supervise(a.run.folder + "/measuring", [&](const std::map<std::string, std::string>& failed) {
    const auto limit = limit_threads(a.run.choice.threads);
    a.run.failed = failed;
    const RunSummary summary = measure(suite, a.run, shapes);
    if (!a.quiet) fmt::print("{}{}", run_table(summary), front_table(summary.records));
    fmt::print("{}", run_totals(suite, a.run, summary));
    if (a.self_check) self_check(suite, a.run, shapes, summary);
    judge.judge(suite.name, a.run.folder, summary.records);
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
  validate->add_option("--gates", a->judge.gates, "quick, or a file of limits; exit with 1 when one is broken");
  validate->add_option("--junit", a->judge.junit, "Write gates and cells as JUnit XML");
  validate->add_option("--baseline", a->judge.baseline, "Folder of an earlier run; exit with 1 when this one is worse");
  validate->add_flag("--self-check", a->self_check, "Measure everything twice and report how far the times differ");
  validate->add_flag("--quiet", a->quiet, "Only totals and verdicts, no table of cells");
  add_threads_option(*validate, a->run.choice.threads);
  validate->footer("Example: opaline validate quick --out out/quick --gates quick --junit out/quick.xml");
  validate->callback([a, &shapes] { run(*a, shapes); });
}

}  // namespace opaline
