// Single scattering in layers along the true ways of the light: what subsurface_texture is judged by.
#include "render/progress.h"
#include "render/subsurface/exact_march.h"
#include "render/subsurface/texture_mapping.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

namespace opaline {
namespace {

Counters named(const ExactCounts& c) {
  Counters counters;
  counters.done = {{"boundary_rays", c.rays.boundary},   {"shadow_rays", c.rays.shadow},
                   {"facets_tested", c.search.facets},   {"nearest_points", c.nearest_points},
                   {"light_paths", c.light_paths},       {"estimates", c.estimates},
                   {"points_unconverged", c.unconverged}};
  counters.skipped = {{"steps_behind_negligible", c.steps_negligible},
                      {"light_paths_shadowed", c.shadowed},
                      {"rays_lost_at_edges", c.lost}};
  return counters;
}

class PreparedExact : public PreparedTechnique {
 public:
  PreparedExact(const SharedScene& shared, const ExactSettings& settings) : lights_(march_lights(shared.scene)) {
    for (std::size_t i = 0; i < shared.scene.objects.size(); ++i)
      objects_.push_back(std::make_unique<ExactMarch>(shared.scene, shared.rays, static_cast<int>(i), settings));
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.radiance.resize(view.points.size());
    std::vector<glm::vec3>& error = frame.images["error"];
    error.resize(view.points.size());
    tbb::enumerable_thread_specific<ExactCounts> per_thread;
    Progress progress(view.points.size());
    tbb::parallel_for(std::size_t{0}, view.points.size(), [&](std::size_t i) {
      const ExactMarch& object = *objects_[static_cast<std::size_t>(view.points[i].object)];
      const ExactMarch::Estimate e = object.radiance(view.points[i], lights_, per_thread.local());
      frame.radiance[i] = glm::vec3(e.radiance), error[i] = glm::vec3(e.error);
      progress.advance(1);
    });
    for (const ExactCounts& c : per_thread) frame.counters += named(c);
    return frame;
  }

 private:
  std::vector<MarchLight> lights_;
  std::vector<std::unique_ptr<ExactMarch>> objects_;
};

std::string not_applicable(const Scene& scene) {
  for (const Object& object : scene.objects)
    if (const std::string fault = closed_mesh_fault(object.mesh); !fault.empty())
      return fmt::format("object '{}': {}", object.name, fault);
  return texture_mapping_not_applicable(scene);
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return std::make_unique<PreparedExact>(
      shared, ExactSettings{settings.word("refraction") == "on", settings.number("max_relative_error"),
                            static_cast<int>(settings.number("most_steps"))});
}

}  // namespace

Technique single_scatter_exact_technique() {
  return {
      .name = "single_scatter_exact",
      .summary = "single scattering in layers along the light's true ways, converged, with its error per pixel",
      .citation =
          "refraction into facets: Walter, Zhao, Holzschuh, Bala 2009, \"Single Scattering in Refractive "
          "Media with Triangle Mesh Boundaries\"; the layers: Francois et al. 2006",
      .backends = {"cpu"},
      .limits =
          "materials with layers; closed meshes; directional and point lights without extent; flat facets "
          "refract; no light that a boundary reflects inside, and none that has left and enters again",
      .settings = {{"refraction", "off", "at the surface, by the material's eta", {"off", "on"}},
                   {"max_relative_error", "1e-3", "of a pixel's brightest channel", {}, 1e-6, 0.5},
                   {"most_steps", "512", "along the view ray, however large the error still is", {}, 32, 65536, true}},
      .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
      .not_applicable = not_applicable,
      .prepare = prepare,
      .needs_irradiance = false,
      .materials = {MaterialKind::layered}};
}

}  // namespace opaline
