#include "fit/fit_job.h"

#include "fit/profile_interval.h"
#include "fit/reduced_picture.h"
#include "fit/rendered_reference.h"
#include "fit/residual_structure.h"
#include "fit/straight_view.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

namespace opaline {
namespace {

void check_counts(const FitJob& job) {
  if (job.targets.empty()) throw InputError("--target", "", "name at least one picture");
  if (job.scenes.size() != 1 && job.scenes.size() != job.targets.size())
    throw InputError("SCENE", "",
                     fmt::format("{} scenes for {} targets: give one scene for all, or one each", job.scenes.size(),
                                 job.targets.size()));
  if (job.exposures.size() > 1 && job.exposures.size() != job.targets.size())
    throw InputError("--exposure", "",
                     fmt::format("{} exposures for {} targets: give none, one for all, or one each",
                                 job.exposures.size(), job.targets.size()));
  if (!job.repeats.empty() && job.repeats.size() != job.targets.size())
    throw InputError("--repeat", "",
                     fmt::format("{} second captures for {} targets: give none, or one each", job.repeats.size(),
                                 job.targets.size()));
  if (job.masks.size() > 1 && job.masks.size() != job.targets.size())
    throw InputError("--mask", "",
                     fmt::format("{} masks for {} targets: give none, one for all, or one each", job.masks.size(),
                                 job.targets.size()));
}

const ProfileInfo& model_of(const FitJob& job) {
  const ProfileInfo* info = find_profile(job.model);
  if (info != nullptr && info->needs_medium_alone()) return *info;
  throw InputError("--model", "", unknown_choice("model", job.model, medium_profile_names()));
}

/// Index of the fitted material: the named one, or the only one that objects use.
int fitted_material(const Scene& scene, const std::string& name) {
  std::vector<std::string> used;
  int found = -1;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    const bool in_use = std::any_of(scene.objects.begin(), scene.objects.end(),
                                    [&](const Object& o) { return o.material == static_cast<int>(i); });
    if (!in_use) continue;
    used.push_back(scene.materials[i].name);
    if (name.empty() || scene.materials[i].name == name) found = static_cast<int>(i);
  }
  if (!name.empty() && found < 0) throw InputError(scene.path, "--material", unknown_choice("material", name, used));
  if (name.empty() && used.size() > 1)
    throw InputError(scene.path, "", "has several materials; choose one with --material: " + join_names(used));
  for (const Object& object : scene.objects)
    if (const Material& m = scene.materials[static_cast<std::size_t>(object.material)]; m.textured() || m.layers)
      throw InputError(scene.path, "",
                       "material \"" + m.name + "\" has maps or layers; a fit needs homogeneous materials");
  return found;
}

/// eta is free: nodes over its range. Fixed: the scene's own value, exactly.
EtaNodes eta_nodes(const FitJob& job, const Scene& scene, int material) {
  const ParameterBounds& bounds = job.solve.bounds;
  if (job.solve.free.eta) return EtaNodes(bounds.eta_min, bounds.eta_max, 8);
  return EtaNodes(scene.materials[static_cast<std::size_t>(material)].eta);
}

std::vector<TargetScene> load_scenes(const FitJob& job, const ShapeLibrary& shapes) {
  std::vector<TargetScene> loaded;
  for (const std::string& path : job.scenes) {
    auto scene = std::make_shared<const Scene>(load_scene(path, shapes));
    const int material = fitted_material(*scene, job.material);
    const double eta = scene->materials[static_cast<std::size_t>(material)].eta,
                 other = loaded.empty()
                             ? eta
                             : loaded.front().scene->materials[static_cast<std::size_t>(loaded.front().material)].eta;
    if (!job.solve.free.eta && eta != other)
      throw InputError(path, "",
                       fmt::format("eta is {} here but {} in {}; with eta fixed all scenes must agree", eta, other,
                                   job.scenes.front()));
    loaded.push_back({std::move(scene), material});
  }
  while (loaded.size() < job.targets.size()) loaded.push_back(loaded.front());
  return loaded;
}

TargetOptions options_of(const FitJob& job, std::size_t i) {
  TargetOptions options = job.reading;
  if (!job.masks.empty()) options.mask = job.masks[std::min(i, job.masks.size() - 1)];
  if (!job.exposures.empty()) options.exposure = job.exposures[std::min(i, job.exposures.size() - 1)];
  if (!job.repeats.empty()) options.repeat = job.repeats[i];
  return options;
}

/// The operator of the pixels that any target of this scene uses.
TransportOperator usable_operator(const FitJob& job, const TargetScene& loaded, const std::vector<float>& mask) {
  const Scene& scene = *loaded.scene;
  TransportOperator op = build_operator(scene, loaded.material, eta_nodes(job, scene, loaded.material), job.op, mask);
  if (op.rows() > 0 && std::all_of(op.values.begin(), op.values.end(), [](float value) { return value == 0; }))
    throw InputError(scene.path, "/lights", "no light reaches the fitted object: it is black whatever it is made of");
  return op;
}

/// Targets of one scene, such as exposures of one view, share its operator.
struct SceneGroup {
  std::size_t first;
  std::vector<std::size_t> targets;
};

std::vector<SceneGroup> group_by_scene(const std::vector<TargetScene>& loaded) {
  std::vector<SceneGroup> groups;
  for (std::size_t i = 0; i < loaded.size(); ++i) {
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const SceneGroup& g) { return loaded[g.first].scene == loaded[i].scene; });
    if (same == groups.end())
      groups.push_back({i, {i}});
    else
      same->targets.push_back(i);
  }
  return groups;
}

std::vector<float> union_of_masks(const std::vector<TargetPicture>& pictures, const SceneGroup& group) {
  std::vector<float> any = pictures[group.first].usable;
  for (const std::size_t i : group.targets)
    for (std::size_t p = 0; p < any.size(); ++p) any[p] = std::max(any[p], pictures[i].usable[p]);
  return any;
}

FittedTarget describe(const FitJob& job, const TargetScene& loaded, const FitTarget& fitted, std::size_t i,
                      const ProfileInfo& profile, const FitReport& report) {
  FittedTarget out;
  out.scene = job.scenes[std::min(i, job.scenes.size() - 1)];
  out.target = job.targets[i];
  out.scale = std::exp(report.solution.ln_scale[i]);
  out.noise = fitted.noise;
  out.refit = target_image(fitted, profile, report.material, out.scale);
  out.picture = out.difference = Image(out.refit.width, out.refit.height, {"R", "G", "B", "A"});
  for (std::size_t row = 0; row < fitted.rows(); ++row)
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t at = fitted.op.pixels[row] * 4u + c;
      const auto column =
          static_cast<Eigen::Index>(std::min<std::size_t>(c, static_cast<std::size_t>(fitted.channels) - 1));
      const auto p = static_cast<Eigen::Index>(row);
      const float value = c == 3 ? 1 : static_cast<float>(fitted.picture(p, column));
      const float off = c == 3 || fitted.offset.size() == 0 ? 0 : static_cast<float>(fitted.offset(p, column));
      out.difference.data[at] = c == 3 ? 1 : out.refit.data[at] - value;
      out.picture.data[at] = value + off;
      out.refit.data[at] += off;
    }
  out.neighbour_correlation = neighbour_correlation(out.difference);
  out.operator_error = operator_error(*loaded.scene, fitted, job.op, profile, report.material, loaded.material);
  out.counters = fitted.op.counters;
  return out;
}

/// Reads all targets before any operator is gathered: wrong input ends early.
std::vector<TargetPicture> read_targets(const FitJob& job, const std::vector<TargetScene>& loaded) {
  std::vector<TargetPicture> pictures;
  for (std::size_t i = 0; i < job.targets.size(); ++i)
    pictures.push_back(read_target(job.targets[i], *loaded[i].scene, options_of(job, i)));
  return pictures;
}

/// Operators and reductions of all targets, in their order.
std::vector<FitTarget> make_targets(const FitJob& job, const std::vector<TargetScene>& loaded,
                                    const std::vector<TargetPicture>& pictures, FitReport& report,
                                    const std::function<void(const std::string&)>& stage) {
  std::vector<std::optional<FitTarget>> made(job.targets.size());
  Stopwatch watch;
  std::size_t number = 0;
  const std::vector<SceneGroup> groups = group_by_scene(loaded);
  for (const SceneGroup& group : groups) {
    stage(fmt::format("operator {}/{}", ++number, groups.size()));
    watch.lap();
    TransportOperator op = usable_operator(job, loaded[group.first], union_of_masks(pictures, group));
    report.operator_seconds += op.seconds;
    stage("reduce");
    for (const std::size_t i : group.targets) {
      const bool alone = group.targets.size() == 1;
      made[i] = make_target(alone ? std::move(op) : some_rows(op, pictures[i].usable), pictures[i].linear,
                            job.targets[i], pictures[i].noise);
      made[i]->scale_free = job.scale_free;
    }
    report.solve_seconds += watch.lap() - made[group.first]->op.seconds;
  }
  std::vector<FitTarget> targets;
  for (auto& target : made) targets.push_back(std::move(*target));
  return targets;
}

/// Covariance, intervals, words and repetitions of the solution.
void examine(const FitJob& job, const std::vector<FitTarget>& targets, const ProfileInfo& profile,
             const std::function<void(const std::string&)>& stage, FitReport& report) {
  const Solution& s = report.solution;
  report.uncertainty = uncertainty(s, job.solve.free);
  const FitProblem problem(targets, s.whitened, profile, report.job.solve, s.bounds);
  const bool measured = report.correction && report.correction->measured;  // then the operator's likelihood is not it
  if (job.profile_intervals && job.solve.loss.kind == RobustLoss::Kind::squares && !measured && !rough_noise(targets))
    profile_intervals(problem, s, report.uncertainty);
  report.diagnosis = diagnose(s, report.uncertainty);
  if (job.bootstrap == 0) return;
  stage("bootstrap");
  if (rough_noise(targets))
    report.uncertainty.notes.emplace_back(
        "the repetitions draw noise that the channels do not share; the intervals above count what they do");
  report.repetitions = bootstrap(problem, s, job.bootstrap, job.solve.seed,
                                 measured ? report.correction->sensitivity : Eigen::MatrixXd());
}

/// The profile, and with it report.solution; a second form of transport is tried where all targets are straight on.
const ProfileInfo& solve_for_profile(const FitJob& job, const std::vector<TargetScene>& loaded,
                                     const std::vector<FitTarget>& targets, const Material& initial, FitReport& report,
                                     std::string& note) {
  const ProfileInfo& profile = model_of(job);
  report.solution = solve(targets, profile, initial, report.job.solve);
  report.solve_seconds += report.solution.seconds;
  if (job.model != "transport_table" || job.exitance_only) return profile;
  double off = 0;
  for (std::size_t i = 0; i < loaded.size() && off <= straight_within_deg; ++i)
    if (i == 0 || loaded[i].scene != loaded[i - 1].scene)
      off = std::max(off, off_straight_deg(*loaded[i].scene, loaded[i].material));
  if (off > straight_within_deg) return profile;
  TransportForm form = preferred_form(targets, initial, report.job.solve, std::move(report.solution), off);
  report.solution = std::move(form.solution);
  report.solve_seconds += report.solution.seconds;
  report.job.model = form.profile->name;
  note = form.note;
  return *form.profile;
}

/// Makes the fit that of the reference technique, if the job has one.
void correct(const FitJob& job, const std::vector<TargetScene>& loaded, std::vector<FitTarget>& targets,
             const ProfileInfo& profile, const Material& initial, FitReport& report) {
  RenderOptions options = *job.reference;
  options.shared = {job.op.samples, job.op.irradiance};
  const FreeParameters& free = job.solve.free;
  report.correction = correct_by_reference(targets, profile, initial, job.solve,
                                           rendered_reference(loaded, targets, initial, free, options), job.correction,
                                           report.solution);
  report.solve_seconds += report.correction->seconds;
}

/// How far the correction went, and what it leaves open.
void add_correction_note(const FitJob& job, FitReport& report) {
  const Correction& c = *report.correction;
  const CorrectionStep& last = c.steps.back();
  report.uncertainty.notes.push_back(
      c.converged
          ? fmt::format("corrected by {}, {} renders: the operator alone is {:.2g} of the picture (rms) off there",
                        job.reference->technique, c.renders, last.defect)
          : fmt::format(
                "the correction by {} did not settle in {} steps (the next would be {:.2g} standard deviations long): "
                "allow more, or make its pictures less noisy",
                job.reference->technique, c.steps.size(), last.next_step_sd));
}

/// What the residual says against the fit, whatever its size.
void add_residual_notes(FitReport& report) {
  std::vector<std::string>& notes = report.uncertainty.notes;
  for (const FittedTarget& t : report.targets) {
    const double sigmas = t.neighbour_correlation * std::sqrt(static_cast<double>(t.counters.done.at("rows")));
    if (t.neighbour_correlation > 0.1 && sigmas > 6)
      notes.push_back(
          fmt::format("{}: the residual is not noise (neighbours correlate by {:.2f}): the model, the scene's "
                      "description or shared "
                      "noise leaves structure, and the intervals do not cover it",
                      t.target, t.neighbour_correlation));
  }
  const double misfit = report.solution.chi_squared / std::max(report.solution.freedom, 1.0);
  bool known = false;
  for (const FittedTarget& t : report.targets) known |= t.noise.known;
  if (known && misfit > 1.2)
    notes.push_back(
        fmt::format("the residual is {:.2f} times the stated noise (chi-squared {:.2f} per value): the model "
                    "or the noise is not right, and the intervals are too narrow by about that factor",
                    std::sqrt(misfit), misfit));
}

}  // namespace

FitReport run_fit(const FitJob& job, const ShapeLibrary& shapes,
                  const std::function<void(const std::string&)>& progress) {
  const auto stage = [&](const std::string& name) {
    if (progress) progress(name);
  };
  check_counts(job);
  model_of(job);  // a wrong name ends before the work
  Stopwatch total;
  stage("load");
  const std::vector<TargetScene> loaded = load_scenes(job, shapes);
  if (job.reference) check_reference(*job.reference, loaded);
  const std::vector<TargetPicture> pictures = read_targets(job, loaded);
  FitReport report;
  report.job = job;
  std::vector<FitTarget> targets = make_targets(job, loaded, pictures, report, stage);
  stage("solve");
  const Material& initial = loaded.front().scene->materials[static_cast<std::size_t>(loaded.front().material)];
  std::string form;
  const ProfileInfo& profile = solve_for_profile(job, loaded, targets, initial, report, form);
  if (job.compare_models) {
    stage("compare");
    report.comparison =
        compare_models(targets, profile.name, report.solution, uncertainty(report.solution, job.solve.free),
                       to_material(report.solution.parameters, initial, job.solve.free), job.solve);
  }
  if (job.reference) {
    stage("correct");
    correct(job, loaded, targets, profile, initial, report);
  }
  examine(job, targets, profile, stage, report);
  report.material = to_material(report.solution.parameters, initial, job.solve.free);
  if (report.correction) add_correction_note(job, report);
  if (!form.empty()) report.uncertainty.notes.push_back(form);
  const bool by_transport = report.correction && find_technique(job.reference->technique).statistical;
  if ((profile.name == "transport_table" || profile.radiance) && !by_transport) {
    report.surface = surface_bias(surface_shape(*loaded.front().scene, loaded.front().material), report.material);
    if (!report.surface->note.empty()) report.uncertainty.notes.push_back(report.surface->note);
  }
  stage("check");
  for (std::size_t i = 0; i < targets.size(); ++i) {
    report.targets.push_back(describe(job, loaded[i], targets[i], i, profile, report));
    report.targets[i].saturated = pictures[i].saturated;
    report.targets[i].near_highlights = pictures[i].near_highlights;
  }
  add_residual_notes(report);
  if (job.advise) {
    stage("advise");
    report.advice = advise(*loaded.front().scene, loaded.front().material, profile, report.solution, report.uncertainty,
                           job.solve.free, std::clamp(report.solution.relative_rmse, 1e-4, 0.1));
  }
  report.total_seconds = total.lap();
  return report;
}

}  // namespace opaline
