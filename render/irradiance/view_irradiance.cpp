#include "render/irradiance/view_irradiance.h"

#include "render/irradiance/entering_light.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace opaline {
namespace {

/// Per object, as EnteringLight takes them.
std::vector<std::vector<double>> object_etas(const Scene& scene) {
  std::vector<std::vector<double>> etas;
  for (const Object& object : scene.objects)
    etas.push_back({scene.materials[static_cast<std::size_t>(object.material)].eta});
  return etas;
}

}  // namespace

ViewIrradiance view_irradiance(const Scene& scene, const RayScene& rays, const GBuffer& view,
                               const IrradianceSettings& settings, bool unshadowed, Counters& counters) {
  const LightSampler lights(scene, settings.area_samples);
  const std::vector<std::vector<double>> etas = object_etas(scene);
  ViewIrradiance irradiance;
  irradiance.channels = lights.single_colour(irradiance.colour) ? 1 : 3;
  if (irradiance.channels == 3) irradiance.colour = Rgb(1);
  const auto channels = static_cast<std::size_t>(irradiance.channels);
  irradiance.values.resize(view.points.size() * channels);
  std::atomic<std::uint64_t> done = 0, skipped = 0, spared = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.points.size(), 512), [&](const auto& range) {
    std::uint64_t cast = 0, away = 0, not_needed = 0;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const VisiblePoint& p = view.points[i];
      const auto object = static_cast<std::size_t>(p.object);
      EnteringLight light{rays, lights, etas[object], irradiance.channels, unshadowed};
      double sum[3] = {};
      light.add(surface_point_at(scene.objects[object].mesh, p.triangle, p.position), settings.seed ^ p.pixel, 0, 1,
                sum);
      for (std::size_t c = 0; c < channels; ++c) irradiance.values[i * channels + c] = static_cast<float>(sum[c]);
      cast += light.done, away += light.skipped, not_needed += light.spared;
    }
    done += cast, skipped += away, spared += not_needed;
  });
  counters.done["shadow_rays"] += done;
  counters.skipped["shadow_rays_facing_away"] += skipped;
  counters.skipped["shadow_rays_nothing_in_shadow"] += spared;
  return irradiance;
}

}  // namespace opaline
