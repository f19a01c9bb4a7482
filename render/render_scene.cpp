#include "render/render_scene.h"

#include "render/choices.h"
#include "render/gl/context.h"
#include "render/input_error.h"
#include "render/stopwatch.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

/// The technique if all options fit it.
const Technique& checked_technique(const RenderOptions& options) {
  const Technique& technique = find_technique(options.technique);
  const std::vector<std::string>& backends = technique.backends;
  if (!options.backend.empty() && std::find(backends.begin(), backends.end(), options.backend) == backends.end()) {
    throw InputError("--backend", "",
                     fmt::format("technique '{}' has no backend '{}'; it has: {}", technique.name, options.backend,
                                 join_names(backends)));
  }
  [[maybe_unused]] const gl::Api api = gl::parse_api(options.gl);                  // throws
  [[maybe_unused]] const Settings settings(technique.settings, options.settings);  // throws
  return technique;
}

void check_applicable(const Technique& technique, const Scene& scene) {
  const std::string reason = why_not_applicable(technique, scene);
  if (reason.empty()) return;
  throw InputError(scene.path, "", fmt::format("technique '{}' cannot render this scene: {}", technique.name, reason));
}

nlohmann::json to_json(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

nlohmann::json to_json(const Camera& camera) {
  nlohmann::json json = {
      {"position", to_json(camera.position)}, {"look_at", to_json(camera.look_at)}, {"up", to_json(camera.up)}};
  const bool perspective = camera.type == Camera::Type::perspective;
  json["type"] = perspective ? "perspective" : "orthographic";
  json[perspective ? "fov_y_deg" : "height"] = perspective ? camera.fov_y_deg : camera.height;
  return json;
}

}  // namespace

void check_render_options(const RenderOptions& options) { checked_technique(options); }

RenderResult render_scene(const Scene& scene, const RenderOptions& options, const StageObserver& observer) {
  const auto stage = [&](const char* name) {
    if (observer) observer(name);
  };
  const Technique& technique = checked_technique(options);
  check_applicable(technique, scene);
  const Settings settings(technique.settings, options.settings);
  RenderResult result;
  result.backend = options.backend.empty() ? technique.backends.front() : options.backend;
  result.settings = settings.values();
  std::unique_ptr<gl::Context> context;
  if (result.backend == "gpu") {
    context = gl::Context::create(gl::parse_api(options.gl));
    result.device = context->info().description();
  }
  stage("irradiance");
  Stopwatch watch;
  const SharedScene shared(scene, options.shared, technique.needs_irradiance);
  result.seconds.irradiance = shared.seconds.irradiance;
  result.seconds.gbuffer = std::max(0.0, watch.lap() - shared.seconds.irradiance);
  stage("prepare");
  const auto prepared =
      context ? technique.prepare_gpu(shared, settings, *context) : technique.prepare(shared, settings);
  result.seconds.prepare = watch.lap();
  stage("render");
  const Frame frame = prepared->render(shared.view);
  result.image = shade(scene, shared.view, frame, options.exit_lobe);
  result.layers = shade_layers(scene, shared.view, frame, options.exit_lobe);
  result.seconds.render = watch.lap();
  result.estimates = frame.estimates;
  result.counters = shared.counters;
  result.counters += frame.counters;
  result.notes = frame.notes;
  result.counters.skipped["zero_area_triangles"] += scene.dropped_triangles;
  return result;
}

std::map<std::string, std::string> image_header(const Scene& scene, const RenderOptions& options,
                                                const RenderResult& result) {
  return {{"opaline:technique", options.technique},
          {"opaline:backend", result.backend},
          {"opaline:settings", nlohmann::json(result.settings).dump()},
          {"opaline:scene", scene.path},
          {"opaline:camera", to_json(scene.camera).dump()},
          {"opaline:exit_lobe", exit_lobe_name(options.exit_lobe)},
          {"opaline:samples", std::to_string(options.shared.samples)},
          {"opaline:light_samples", std::to_string(options.shared.irradiance.area_samples)},
          {"opaline:seed", std::to_string(options.shared.irradiance.seed)},
          {"opaline:version", version()}};
}

std::string exit_lobe_name(ExitLobe lobe) { return lobe == ExitLobe::jensen ? "jensen" : "normalised"; }

std::string version() { return OPALINE_VERSION; }

}  // namespace opaline
