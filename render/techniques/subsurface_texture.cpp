// Single scattering in layers whose thickness stands in a texture, by a march with planes in place of the surface.
// subsurface_texture.md has the derivation, the paper's misprints and the limits.
#include "render/subsurface/texture_mapping.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <mutex>

namespace opaline {
namespace {

class PreparedMapping : public PreparedTechnique {
 public:
  PreparedMapping(const SharedScene& shared, const TextureMappingSettings& settings)
      : shared_(shared), settings_(settings), mapped_(make_mapped_scene(shared.scene, settings)) {}

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.radiance.resize(view.points.size());
    frame.counters = mapped_.counters;
    std::vector<MarchCounts> counts(mapped_.objects.size());
    std::mutex mutex;
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.points.size(), 64), [&](const auto& range) {
      std::vector<MarchCounts> own(counts.size());
      for (std::size_t i = range.begin(); i != range.end(); ++i)
        frame.radiance[i] = radiance(view.points[i], own[static_cast<std::size_t>(view.points[i].object)]);
      const std::scoped_lock lock(mutex);
      for (std::size_t o = 0; o < own.size(); ++o) counts[o] += own[o];
    });
    for (std::size_t o = 0; o < counts.size(); ++o) add_counts(counts[o], *mapped_.objects[o], frame.counters);
    return frame;
  }

 private:
  glm::vec3 radiance(const VisiblePoint& v, MarchCounts& counts) const {
    const auto o = static_cast<std::size_t>(v.object);
    const MappedObject& object = *mapped_.objects[o];
    const FramedPoint p = framed_point(shared_.scene.objects[o].mesh, object.frames, v);
    const std::uint32_t visible = mapped_.visible(shared_, v, counts);
    glm::vec3 sum = march(p, object.medium, mapped_.lights, visible, settings_.march, counts);
    for (std::size_t l = 0; l < mapped_.lights.size() && settings_.reflection; ++l)
      if (visible >> l & 1) sum += gloss(p, mapped_.lights[l], object.reflectance, settings_.roughness);
    return sum;
  }

  static void add_counts(const MarchCounts& c, const MappedObject& object, Counters& counters) {
    counters.done["march_samples"] += c.samples;
    counters.done["light_paths"] += c.light_paths;
    counters.done["shadow_rays"] += c.shadow_rays;
    counters.done["grazing_points"] += c.grazing_points;
    counters.skipped["march_samples_behind_negligible"] += c.samples_negligible;
    counters.skipped["light_paths_from_behind"] += c.light_paths_from_behind;
    counters.skipped["light_paths_shadowed"] += c.light_paths_shadowed;
    if (c.samples > 0)
      counters.skipped["layers_nobody_reaches"] +=
          static_cast<std::uint64_t>(std::max(0, object.medium.stack.count - c.deepest));
  }

  const SharedScene& shared_;
  TextureMappingSettings settings_;
  MappedScene mapped_;
};

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return std::make_unique<PreparedMapping>(shared, read_texture_mapping_settings(settings));
}

}  // namespace

Technique subsurface_texture_technique() {
  return {
      .name = "subsurface_texture",
      .summary = "single scattering in layers of varying thickness: a march through textures, planes for the surface",
      .citation = "Francois, Pattanaik, Bouatouch, Breton 2006, \"Subsurface Texture Mapping\"",
      .backends = {"cpu", "gpu"},
      .limits =
          "materials with layers; directional and point lights without extent; no refraction; light that comes from "
          "behind the surface's planes, as through a thin fin, is missing",
      .settings = texture_mapping_setting_specs(),
      .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
      .not_applicable = texture_mapping_not_applicable,
      .prepare = prepare,
      .needs_irradiance = false,
      .prepare_gpu = prepare_subsurface_texture_gl,
      .twin_tolerance = 1e-4,
      .materials = {MaterialKind::layered}};
}

}  // namespace opaline
