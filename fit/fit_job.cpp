#include "fit/fit_job.h"

#include "render/choices.h"
#include "render/input_error.h"
#include "render/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace opaline {
namespace {

void check_counts(const FitJob& job) {
  if (job.targets.empty()) throw InputError("--target", "", "name at least one picture");
  if (job.scenes.size() != 1 && job.scenes.size() != job.targets.size())
    throw InputError("SCENE", "",
                     fmt::format("{} scenes for {} targets: give one scene for all, or one each", job.scenes.size(),
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

std::vector<float> read_mask(const std::string& path, const Scene& scene) {
  const Image image = read_image(path);
  if (image.width != scene.film.width || image.height != scene.film.height)
    throw InputError(path, "",
                     fmt::format("the mask is {} x {} pixels, but the scene's film is {} x {}", image.width,
                                 image.height, scene.film.width, scene.film.height));
  std::vector<float> mask(image.pixel_count());
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = image.data[i * image.channels.size()];
  return mask;
}

/// eta is free: nodes over its range. Fixed: the scene's own value, exactly.
EtaNodes eta_nodes(const FitJob& job, const Scene& scene, int material) {
  const ParameterBounds& bounds = job.solve.bounds;
  if (job.solve.free.eta) return EtaNodes(bounds.eta_min, bounds.eta_max, 8);
  return EtaNodes(scene.materials[static_cast<std::size_t>(material)].eta);
}

struct Loaded {
  std::shared_ptr<const Scene> scene;
  int material;
};

std::vector<Loaded> load_scenes(const FitJob& job, const ShapeLibrary& shapes) {
  std::vector<Loaded> loaded;
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

/// The operator of one target.
TransportOperator usable_operator(const FitJob& job, const Loaded& loaded, const std::vector<float>& mask) {
  const Scene& scene = *loaded.scene;
  TransportOperator op = build_operator(scene, loaded.material, eta_nodes(job, scene, loaded.material), job.op, mask);
  if (op.rows() > 0 && std::all_of(op.values.begin(), op.values.end(), [](float value) { return value == 0; }))
    throw InputError(scene.path, "/lights", "no light reaches the fitted object: it is black whatever it is made of");
  return op;
}

FittedTarget describe(const FitJob& job, const Loaded& loaded, const FitTarget& fitted, std::size_t i,
                      const ProfileInfo& profile, const Material& material) {
  FittedTarget out;
  out.scene = job.scenes[std::min(i, job.scenes.size() - 1)];
  out.target = job.targets[i];
  out.refit = operator_image(fitted.op, profile, material);
  out.picture = out.difference = Image(out.refit.width, out.refit.height, {"R", "G", "B", "A"});
  const Image picture = read_image(out.target);
  for (const std::uint32_t pixel : fitted.op.pixels)
    for (std::size_t c = 0; c < 4; ++c) {
      const std::size_t at = pixel * 4u + c;
      const float value = c == 3 ? 1
                                 : picture.data[pixel * picture.channels.size() +
                                                static_cast<std::size_t>(picture.channel(std::string(1, "RGB"[c])))];
      out.picture.data[at] = value;
      out.difference.data[at] = c == 3 ? 1 : out.refit.data[at] - value;
    }
  out.operator_error = operator_error(*loaded.scene, fitted.op, job.op, profile, material, loaded.material);
  out.counters = fitted.op.counters;
  return out;
}

}  // namespace

FitReport run_fit(const FitJob& job, const ShapeLibrary& shapes,
                  const std::function<void(const std::string&)>& progress) {
  const auto stage = [&](const std::string& name) {
    if (progress) progress(name);
  };
  Stopwatch total, watch;
  check_counts(job);
  const ProfileInfo& profile = model_of(job);
  stage("load");
  const std::vector<Loaded> loaded = load_scenes(job, shapes);
  FitReport report;
  report.job = job;
  std::vector<FitTarget> targets;
  for (std::size_t i = 0; i < job.targets.size(); ++i) {
    const Scene& scene = *loaded[i].scene;
    const Image picture = read_image(job.targets[i]);
    check_target(picture, scene, job.targets[i]);
    std::vector<float> mask;
    if (!job.masks.empty()) mask = read_mask(job.masks[std::min(i, job.masks.size() - 1)], scene);
    stage(fmt::format("operator {}/{}", i + 1, job.targets.size()));
    watch.lap();
    TransportOperator op = usable_operator(job, loaded[i], mask);
    report.operator_seconds += op.seconds;
    stage("reduce");
    targets.push_back(make_target(std::move(op), picture, job.targets[i]));
    report.solve_seconds += watch.lap() - targets.back().op.seconds;
  }
  stage("solve");
  const Material& initial = loaded.front().scene->materials[static_cast<std::size_t>(loaded.front().material)];
  report.solution = solve(targets, profile, initial, report.job.solve);
  report.solve_seconds += report.solution.seconds;
  report.uncertainty = uncertainty(report.solution, report.job.solve.free);
  report.material = to_material(report.solution.parameters, initial, job.solve.free);
  stage("check");
  for (std::size_t i = 0; i < targets.size(); ++i)
    report.targets.push_back(describe(job, loaded[i], targets[i], i, profile, report.material));
  report.total_seconds = total.lap();
  return report;
}

}  // namespace opaline
