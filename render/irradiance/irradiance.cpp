#include "render/irradiance/irradiance.h"

#include "render/irradiance/entering_light.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace opaline {
namespace {

std::uint64_t cell_seed(const IrradianceSettings& settings, std::size_t object, std::uint64_t cell) {
  return settings.seed * 0x9e3779b97f4a7c15ull + object * 0x100000001b3ull + cell;
}

/// Is the cell large against the footprint of a projector it may lie in? Points of such a cell could
/// all miss the beam.
bool coarse_for_projector(const Scene& scene, const SurfaceCell& cell) {
  const glm::dvec3 centroid(cell_centroid(cell));
  const double size = static_cast<double>(glm::length(cell.a - cell_centroid(cell)));
  for (const Light& light : scene.lights) {
    const auto* projector = std::get_if<ProjectorLight>(&light);
    if (!projector) continue;
    const glm::dvec3 axis = glm::normalize(projector->look_at - projector->position);
    const double depth = glm::dot(centroid - projector->position, axis);
    const double degrees = projector->image ? projector->fov_y_deg / 2 : projector->disk_radius_deg;
    const double footprint = depth * std::tan(degrees * pi / 180);
    const double off_axis = glm::length(centroid - projector->position - depth * axis);
    if (depth > 0 && size > footprint / 8 && off_axis < 2 * footprint + size) return true;
  }
  return false;
}

/// Splits one object's cells; the light is looked at as it arrives (no Fresnel factor).
class EdgeRefiner {
 public:
  EdgeRefiner(const Scene& scene, const RayScene& rays, const LightSampler& lights, std::size_t object,
              const IrradianceSettings& settings)
      : scene_(scene), object_(object), settings_(settings), light_{rays, lights, plain_, 1} {}

  /// Largest minus smallest irradiance over the cell's quarters, times its area; and its flux.
  std::pair<double, double> spread_and_flux(const SurfaceCell& cell, std::uint64_t number) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    double lo = 1e300, hi = 0, sum = 0;
    const auto look = [&](const glm::vec3& point, std::uint32_t index) {
      double e = 0;
      light_.add(surface_point_at(scene_.objects[object_].mesh, cell.triangle, point),
                 cell_seed(settings_, object_, number), index, 1, &e);
      lo = std::min(lo, e), hi = std::max(hi, e);
      return e;
    };
    for (std::uint32_t q = 0; q < 4; ++q) sum += look(cell_centroid(quarters[q]), q) / 4;
    // Just inside the corners too: an edge may cut one off and miss every quarter's centre.
    const glm::vec3 centroid = cell_centroid(cell);
    for (const glm::vec3& corner : {cell.a, cell.b, cell.c}) look(corner + 0.02f * (centroid - corner), 0);
    const double area = static_cast<double>(cell_area(cell));
    return {(hi - lo) * area, sum * area};
  }

  void refine(const SurfaceCell& cell, std::uint64_t number, double allowed, int depth, SurfaceCells& out) {
    const bool split =
        depth < max_depth && (coarse_for_projector(scene_, cell) || spread_and_flux(cell, number).first > allowed);
    if (!split) {
      out.push_back(cell);
      return;
    }
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    for (const SurfaceCell& quarter : quarters) refine(quarter, number, allowed, depth + 1, out);
  }

 private:
  static constexpr int max_depth = 8;
  const Scene& scene_;
  std::size_t object_;
  IrradianceSettings settings_;
  std::vector<double> plain_{1.0};
  EnteringLight light_;
};

/// Mean flux of a cell of one object. Other objects don't matter, so its cells are the same whoever is looked at.
double mean_flux(const Scene& scene, const RayScene& rays, const LightSampler& lights, std::size_t object,
                 const SurfaceCells& cells, const IrradianceSettings& settings) {
  constexpr std::size_t chunk = 4096;
  std::vector<double> partial((cells.size() + chunk - 1) / chunk, 0.0);
  tbb::parallel_for(std::size_t{0}, partial.size(), [&](std::size_t k) {
    EdgeRefiner refiner(scene, rays, lights, object, settings);
    for (std::size_t i = k * chunk; i < std::min(cells.size(), (k + 1) * chunk); ++i)
      partial[k] += refiner.spread_and_flux(cells[i], i).second;
  });
  double flux = 0;
  for (const double part : partial) flux += part;
  return flux / static_cast<double>(std::max<std::size_t>(cells.size(), 1));
}

}  // namespace

std::vector<SurfaceCells> refine_at_light_edges(const Scene& scene, const RayScene& rays,
                                                std::vector<SurfaceCells> cells, const IrradianceSettings& settings,
                                                Counters& counters) {
  const LightSampler lights(scene, (settings.area_samples + 3) / 4);
  for (std::size_t object = 0; object < cells.size(); ++object) {
    const SurfaceCells& coarse = cells[object];
    const double allowed = mean_flux(scene, rays, lights, object, coarse, settings);
    constexpr std::size_t chunk = 1024;
    std::vector<SurfaceCells> parts((coarse.size() + chunk - 1) / chunk);
    tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t k) {
      EdgeRefiner refiner(scene, rays, lights, object, settings);
      for (std::size_t i = k * chunk; i < std::min(coarse.size(), (k + 1) * chunk); ++i)
        refiner.refine(coarse[i], i, allowed, 0, parts[k]);
    });
    SurfaceCells fine;
    for (const SurfaceCells& part : parts) fine.insert(fine.end(), part.begin(), part.end());
    counters.done["cells_added_at_light_edges"] += fine.size() - coarse.size();
    cells[object] = std::move(fine);
  }
  return cells;
}

namespace {

/// What the fields of all objects have in common.
struct FieldMaker {
  const Scene& scene;
  const RayScene& rays;
  const IrradianceSettings& settings;
  LightSampler lights;
  Rgb colour{1};
  int channels;
  std::atomic<std::uint64_t> done = 0, skipped = 0;

  FieldMaker(const Scene& s, const RayScene& r, const IrradianceSettings& i)
      : scene(s),
        rays(r),
        settings(i),
        lights(scene, (settings.area_samples + 3) / 4),
        channels(lights.single_colour(colour) ? 1 : 3) {}

  IrradianceField make(std::size_t object, const SurfaceCells& cells, std::size_t first_number,
                       const std::vector<double>& etas, bool keep_quarters) {
    IrradianceField field{static_cast<int>(etas.size()), channels, channels == 1 ? colour : Rgb(1), {}, {}};
    const auto width = static_cast<std::size_t>(field.width());
    field.values.resize(cells.size() * width);
    if (keep_quarters) field.quarters.resize(4 * cells.size() * width);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells.size(), 256), [&](const auto& range) {
      EnteringLight light{rays, lights, etas, channels};
      std::vector<double> sum(width), of_quarter(width);
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        std::fill(sum.begin(), sum.end(), 0.0);
        SurfaceCell quarters[4];
        split_in_four(cells[i], quarters);
        const std::uint64_t seed = cell_seed(settings, object, first_number + i);
        for (std::uint32_t q = 0; q < 4; ++q) {
          std::fill(of_quarter.begin(), of_quarter.end(), 0.0);
          light.add(surface_point_at(scene.objects[object].mesh, cells[i].triangle, cell_centroid(quarters[q])), seed,
                    q, 1, of_quarter.data());
          for (std::size_t k = 0; k < width; ++k) sum[k] += 0.25 * of_quarter[k];
          if (!keep_quarters) continue;
          for (std::size_t k = 0; k < width; ++k)
            field.quarters[(4 * i + q) * width + k] = static_cast<float>(of_quarter[k]);
        }
        for (std::size_t k = 0; k < width; ++k) field.values[i * width + k] = static_cast<float>(sum[k]);
      }
      done += light.done;
      skipped += light.skipped;
    });
    return field;
  }

  void count(Counters& counters) const {
    counters.done["shadow_rays"] += done;
    counters.skipped["shadow_rays_facing_away"] += skipped;
  }
};

}  // namespace

std::vector<IrradianceField> compute_irradiance(const Scene& scene, const RayScene& rays,
                                                const std::vector<SurfaceCells>& cells,
                                                const std::vector<std::vector<double>>& eta_nodes,
                                                const IrradianceSettings& settings, Counters& counters,
                                                bool keep_quarters) {
  FieldMaker maker(scene, rays, settings);
  std::vector<IrradianceField> fields;
  for (std::size_t object = 0; object < cells.size(); ++object)
    fields.push_back(maker.make(object, cells[object], 0, eta_nodes[object], keep_quarters));
  maker.count(counters);
  return fields;
}

IrradianceField object_irradiance(const Scene& scene, const RayScene& rays, std::size_t object,
                                  const SurfaceCells& cells, std::size_t first_number,
                                  const IrradianceSettings& settings, Counters& counters) {
  FieldMaker maker(scene, rays, settings);
  const double eta = scene.materials[static_cast<std::size_t>(scene.objects[object].material)].eta;
  IrradianceField field = maker.make(object, cells, first_number, {eta}, true);
  maker.count(counters);
  return field;
}

}  // namespace opaline
