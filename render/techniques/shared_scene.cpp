#include "render/techniques/shared_scene.h"

#include "render/stopwatch.h"

namespace opaline {
namespace {

std::vector<std::vector<double>> material_etas(const Scene& scene) {
  std::vector<std::vector<double>> etas;
  for (const Object& object : scene.objects)
    etas.push_back({scene.materials[static_cast<std::size_t>(object.material)].eta});
  return etas;
}

}  // namespace

SharedScene::SharedScene(const Scene& s, const SharedSettings& shared, bool with_irradiance)
    : scene(s), settings(shared), rays(s) {
  Stopwatch watch;
  view = make_gbuffer(scene, rays);
  seconds.gbuffer = watch.lap();
  counters += view.counters;
  if (!with_irradiance) {
    counters.skipped["surface_cells"] += settings.samples;
    return;
  }
  make_irradiance();
  seconds.irradiance = watch.lap();
}

SharedScene::SharedScene(const Scene& s, const SharedSettings& shared, SharedParts parts)
    : SharedParts(std::move(parts)), scene(s), settings(shared), rays(s) {}

void SharedScene::make_irradiance() {
  cells =
      refine_at_light_edges(scene, rays, make_surface_cells(scene, settings.samples), settings.irradiance, counters);
  irradiance = compute_irradiance(scene, rays, cells, material_etas(scene), settings.irradiance, counters, true);
  for (const SurfaceCells& c : cells) counters.done["surface_cells"] += c.size();
}

ObjectPoints points_of_object(const GBuffer& view, int object) {
  ObjectPoints points;
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    if (view.points[i].object != object) continue;
    points.positions.push_back(view.points[i].position);
    points.indices.push_back(static_cast<std::uint32_t>(i));
  }
  return points;
}

}  // namespace opaline
