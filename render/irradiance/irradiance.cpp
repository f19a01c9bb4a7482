#include "render/irradiance/irradiance.h"

#include "model/fresnel.h"
#include "render/irradiance/light_sampler.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>

namespace opaline {
namespace {

struct CellPoint {
  glm::vec3 position, face_normal, normal;
};

/// Position, face normal and shading normal of a point of a cell: the centroid of one quarter.
CellPoint cell_point(const Mesh& mesh, const SurfaceCell& cell, const glm::vec3& position) {
  const glm::uvec3 t = mesh.triangles[cell.triangle];
  const glm::vec3 a = mesh.positions[t.x], ab = mesh.positions[t.y] - a, ac = mesh.positions[t.z] - a;
  const glm::vec3 n = glm::cross(ab, ac), d = position - a;
  const float area2 = glm::dot(n, n);
  const float u = glm::dot(glm::cross(d, ac), n) / area2, v = glm::dot(glm::cross(ab, d), n) / area2;
  const SurfacePoint p = surface_point(mesh, cell.triangle, u, v);
  return {position, p.face_normal, p.normal};
}

std::uint64_t cell_seed(const IrradianceSettings& settings, std::size_t object, std::uint64_t cell) {
  return settings.seed * 0x9e3779b97f4a7c15ull + object * 0x100000001b3ull + cell;
}

struct Worker {
  const Scene& scene;
  const RayScene& rays;
  const LightSampler& lights;
  const std::vector<double>& etas;
  int channels;
  std::uint64_t done = 0, skipped = 0;

  /// Adds the light that enters at one point to out[eta * channels + channel].
  void light_point(const CellPoint& p, std::uint64_t seed, std::uint32_t index, double weight, double* out) {
    lights.for_each(p.position, seed, index, [&](const LightSample& sample) {
      const float cosine = glm::dot(p.normal, sample.direction);
      if (cosine <= 0 || glm::dot(p.face_normal, sample.direction) <= 0) {
        ++skipped;
        return;
      }
      ++done;
      if (rays.occluded(p.position + rays.offset() * p.face_normal, sample.direction, sample.distance)) return;
      const double c = std::min(static_cast<double>(cosine), 1.0);
      for (std::size_t k = 0; k < etas.size(); ++k) {
        const double entering = weight * c * fresnel_transmittance(c, etas[k]);
        for (int ch = 0; ch < channels; ++ch)
          out[k * static_cast<std::size_t>(channels) + static_cast<std::size_t>(ch)] +=
              entering * static_cast<double>(
                             channels == 1 ? std::max({sample.irradiance.r, sample.irradiance.g, sample.irradiance.b})
                                           : sample.irradiance[ch]);
      }
    });
  }
};

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
      : scene_(scene), object_(object), settings_(settings), worker_{scene, rays, lights, plain_, 1} {}

  /// Largest minus smallest irradiance over the cell's quarters, times its area; and its flux.
  std::pair<double, double> spread_and_flux(const SurfaceCell& cell, std::uint64_t number) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    double lo = 1e300, hi = 0, sum = 0;
    const auto look = [&](const glm::vec3& point, std::uint32_t index) {
      double e = 0;
      worker_.light_point(cell_point(scene_.objects[object_].mesh, cell, point), cell_seed(settings_, object_, number),
                          index, 1, &e);
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
  Worker worker_;
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

std::vector<IrradianceField> compute_irradiance(const Scene& scene, const RayScene& rays,
                                                const std::vector<SurfaceCells>& cells,
                                                const std::vector<std::vector<double>>& eta_nodes,
                                                const IrradianceSettings& settings, Counters& counters) {
  const LightSampler lights(scene, (settings.area_samples + 3) / 4);
  Rgb colour(1);
  const int channels = lights.single_colour(colour) ? 1 : 3;
  std::vector<IrradianceField> fields(cells.size());
  std::atomic<std::uint64_t> done = 0, skipped = 0;
  for (std::size_t object = 0; object < cells.size(); ++object) {
    IrradianceField& field = fields[object];
    field = {static_cast<int>(eta_nodes[object].size()), channels, channels == 1 ? colour : Rgb(1), {}};
    const auto width = static_cast<std::size_t>(field.width());
    field.values.resize(cells[object].size() * width);
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, cells[object].size(), 256), [&](const auto& range) {
      Worker worker{scene, rays, lights, eta_nodes[object], channels};
      std::vector<double> sum(width);
      for (std::size_t i = range.begin(); i != range.end(); ++i) {
        std::fill(sum.begin(), sum.end(), 0.0);
        SurfaceCell quarters[4];
        split_in_four(cells[object][i], quarters);
        const std::uint64_t seed = cell_seed(settings, object, i);
        for (std::uint32_t q = 0; q < 4; ++q)
          worker.light_point(cell_point(scene.objects[object].mesh, cells[object][i], cell_centroid(quarters[q])), seed,
                             q, 0.25, sum.data());
        for (std::size_t k = 0; k < width; ++k) field.values[i * width + k] = static_cast<float>(sum[k]);
      }
      done += worker.done;
      skipped += worker.skipped;
    });
  }
  counters.done["shadow_rays"] += done;
  counters.skipped["shadow_rays_facing_away"] += skipped;
  return fields;
}

}  // namespace opaline
