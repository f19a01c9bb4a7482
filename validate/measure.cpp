#include "validate/measure.h"

#include "render/input_error.h"
#include "render/machine.h"
#include "render/render_scene.h"
#include "validate/content_hash.h"
#include "validate/edits.h"
#include "validate/external.h"
#include "validate/metrics/metric.h"
#include "validate/technique_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <stdexcept>

namespace opaline {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

/// Settings that this backend or scene doesn't take, as preparing finds out.
class NotApplicable : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Why the cell cannot be measured, or empty.
std::string not_applicable(const MeasureContext& context, const Cell& cell, const MeasuredScene& scene) {
  if (!cell.technique) return {};
  const std::vector<std::string>& backends = cell.technique->backends;
  if (std::find(backends.begin(), backends.end(), cell.backend) == backends.end())
    return fmt::format("{} has no {} backend", cell.name, cell.backend);
  const std::string reason = why_not_applicable(*cell.technique, scene.scene);
  if (reason.empty() && cell.backend == "gpu" && !context.gl) return context.no_gl;
  return reason;
}

/// What had been found out by then belongs to no result: of the cell only what names it is left.
void end(Record& record, CellStatus status, const std::string& reason) {
  Record blank;
  record.status = status;
  record.reason = reason;
  record.seconds = blank.seconds;
  record.peak_rss_bytes = blank.peak_rss_bytes;
  record.error = blank.error;
  record.truth_error = blank.truth_error;
  record.reference = blank.reference;
  record.done = blank.done;
  record.skipped = blank.skipped;
  record.images = blank.images;
}

std::string command_line(const MeasureContext& context, const Cell& cell, const MeasuredScene& scene) {
  std::string text =
      fmt::format("opaline render {} --technique {} --backend {}", scene.scene_file, cell.name, cell.backend);
  for (const auto& [key, value] : cell.settings) text += fmt::format(" --set {}={}", key, value);
  text += fmt::format(" --samples {} --light-samples {} --seed {}", context.suite.samples, context.suite.light_samples,
                      context.suite.seed);
  if (context.choice.threads > 0) text += fmt::format(" --threads {}", context.choice.threads);
  if (cell.backend == "gpu" && !context.choice.gl.empty()) text += " --gl " + context.choice.gl;
  return text + " --out image.exr";
}

/// Counters as `opaline render --stats` has them.
void set_counters(const TechniqueRun& run, Record& record) {
  Counters counters = run.frame.counters;
  if (run.technique.needs_irradiance) {
    counters += run.scene.shared->counters;
  } else {
    counters += run.scene.shared->view.counters;
    counters.skipped["surface_cells"] += run.scene.shared->settings.samples;
  }
  record.done = counters.done;
  record.skipped = counters.skipped;
}

/// The profile whose exact sum a technique approximates.
std::string profile_of(const Settings* settings, const Suite& suite) {
  if (settings && settings->values().count("profile")) return settings->word("profile");
  const auto of_suite = suite.reference.find("profile");
  return of_suite == suite.reference.end() ? std::string() : of_suite->second;
}

void compare_with_references(const MeasureContext& context, const Cell& cell, const Settings* settings,
                             const Image& image, MeasuredScene& scene, Record& record) {
  if (const ReferenceImage* truth = scene.truth()) {
    record.truth_error = evaluate_metrics(compare_images(image, truth->image));
    record.reference.truth_standard_error = truth->relative_error;
    record.reference.truth_seconds = truth->seconds;
    record.images["truth"] = truth->file;
    record.images["variance"] = truth->error_file;
  }
  if (cell.technique && cell.technique->statistical) {
    record.reason = "an estimate of transport itself: no profile's reference applies";
    return;
  }
  const std::string judge = scene.reference_technique();
  if (judge.empty() || (judge == cell.name && judge != "hierarchical")) {
    record.reason = judge.empty() ? "no reference takes this scene's materials" : "what the others are judged by";
    return;
  }
  const ReferenceImage& reference = scene.reference(profile_of(settings, context.suite));
  record.error = evaluate_metrics(compare_images(image, reference.image));
  record.reference.settings = reference.settings;
  record.reference.certified_relative_error = reference.relative_error;
  record.reference.certified_max = reference.max_error;
  record.reference.seconds = reference.seconds;
  record.images["reference"] = reference.file;
  if (judge == "hierarchical") record.images["bound"] = reference.error_file;
}

void keep_image(const MeasureContext& context, const Image& image, Record& record) {
  if (!context.suite.images) return;
  record.images["render"] = "images/" + record.cell + ".exr";
  write_exr(context.folder + "/" + record.images["render"], image, {{"opaline:command", record.command}});
}

/// Seconds that are the technique's, or asked for: everything else is the harness.
struct Spent {
  double technique = 0, output = 0;
};

void measure_technique(const MeasureContext& context, const Cell& cell, MeasuredScene& scene, Record& record,
                       Spent& spent) {
  const gl::Context* gl = cell.backend == "gpu" ? context.gl : nullptr;
  if (gl) record.machine.gl_renderer = gl->info().description();
  TechniqueRun run(scene, *cell.technique, cell.settings, gl);
  const TimingPlan plan{context.suite.runs, context.suite.max_seconds};
  record.command = command_line(context, cell, scene);
  record.seconds.load = scene.load_seconds;
  record.seconds.gbuffer = scene.shared->seconds.gbuffer;
  record.seconds.irradiance = cell.technique->needs_irradiance ? scene.shared->seconds.irradiance : 0;
  reset_peak_rss();
  try {
    record.seconds.prepare = warm_times(plan, spent.technique, [&] { run.prepare(); });
  } catch (const InputError& error) {
    throw NotApplicable(error.what());
  }
  record.seconds.render = warm_times(plan, spent.technique, [&] { run.render(); });
  record.peak_rss_bytes = peak_rss_bytes();
  set_counters(run, record);
  const Image image = run.image;
  for (const std::string& edit : context.suite.edits)
    record.seconds.edits[edit] = measure_edit(edit, run, plan, spent.technique);
  Stopwatch watch;
  compare_with_references(context, cell, &run.settings, image, scene, record);
  keep_image(context, image, record);
  spent.output += watch.lap();
}

void measure_external(const MeasureContext& context, const Cell& cell, MeasuredScene& scene, Record& record,
                      Spent& spent) {
  const ExternalRun run = run_external(cell.command, context.folder, scene.scene_file, record.cell);
  spent.technique += run.seconds;
  record.command = run.command;
  record.seconds.prepare = make_timing({0});
  record.seconds.render = make_timing({run.seconds});
  record.peak_rss_bytes = run.peak_rss_bytes;
  Stopwatch watch;
  compare_with_references(context, cell, nullptr, run.image, scene, record);
  keep_image(context, run.image, record);
  spent.output += watch.lap();
}

}  // namespace

Record new_record(const Suite& suite, const SceneCase& scene, const Cell& cell) {
  Record record;
  record.cell = cell.hash;
  record.suite = suite.name;
  record.scene = scene.name;
  record.material = scene.material;
  record.technique = cell.name;
  record.backend = cell.backend;
  record.settings = cell.settings;
  record.samples = suite.samples;
  record.light_samples = static_cast<std::uint64_t>(suite.light_samples);
  record.seed = suite.seed;
  record.machine = {cpu_device(), cpu_count(), "", version(), compiler_version(), program_hash(), utc_now()};
  return record;
}

void measure_cell(const MeasureContext& context, const Cell& cell, MeasuredScene& scene, Record& record) {
  Stopwatch watch;
  Spent spent;
  record.film_pixels = scene.shared->view.width * static_cast<std::uint64_t>(scene.shared->view.height);
  try {
    const std::string reason = not_applicable(context, cell, scene);
    if (!reason.empty()) return end(record, CellStatus::not_applicable, reason);
    cell.technique ? measure_technique(context, cell, scene, record, spent)
                   : measure_external(context, cell, scene, record, spent);
  } catch (const NotApplicable& error) {
    end(record, CellStatus::not_applicable, error.what());
  } catch (const std::exception& error) {
    end(record, CellStatus::failed, error.what());
  }
  record.seconds.harness_overhead = std::max(0.0, watch.lap() - spent.technique - spent.output);
}

}  // namespace opaline
