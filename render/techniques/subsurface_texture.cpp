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
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.points.size(), 256), [&](const auto& range) {
      std::vector<MarchCounts> own(counts.size());
      for (std::size_t i = range.begin(), end; i != range.end(); i = end) {
        const int object = view.points[i].object;
        for (end = i + 1; end != range.end() && view.points[end].object == object;) ++end;
        march_points(std::span(view.points).subspan(i, end - i), own[static_cast<std::size_t>(object)],
                     &frame.radiance[i]);
      }
      const std::scoped_lock lock(mutex);
      for (std::size_t o = 0; o < own.size(); ++o) counts[o] += own[o];
    });
    for (std::size_t o = 0; o < counts.size(); ++o)
      frame.counters += MappedScene::named(counts[o], *mapped_.objects[o]);
    return frame;
  }

 private:
  /// Points of one object.
  void march_points(std::span<const VisiblePoint> points, MarchCounts& counts, glm::vec3* radiance) const {
    const MappedObject& object = *mapped_.objects[static_cast<std::size_t>(points[0].object)];
    std::vector<MarchPoint> ready;
    for (const VisiblePoint& p : points) ready.push_back(mapped_.point(shared_, p, counts));
    std::vector<MarchResult> results(points.size());
    march(ready, object.medium, mapped_.lights, settings_.march, results.data());
    for (std::size_t i = 0; i < points.size(); ++i) {
      counts.add(ready[i], results[i], settings_.march.samples, mapped_.lights.size());
      radiance[i] = results[i].radiance + reflected(ready[i], object);
    }
  }

  glm::vec3 reflected(const MarchPoint& p, const MappedObject& object) const {
    glm::vec3 sum(0);
    for (std::size_t l = 0; l < mapped_.lights.size() && settings_.reflection; ++l)
      if (p.visible >> l & 1) sum += gloss(p, mapped_.lights[l], object.reflectance, settings_.roughness);
    return sum;
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
          "materials with layers; directional and point lights without extent; no refraction; a plane for the surface, "
          "and one where light comes through from behind: wrong where the surface bends within the light's reach",
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
