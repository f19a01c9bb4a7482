// Irradiance that has entered the surface cells, for one or several refraction indices at once.
#pragma once

#include "render/counters.h"
#include "render/irradiance/surface_cells.h"
#include "render/visibility/ray_scene.h"

#include <span>
#include <vector>

namespace opaline {

struct IrradianceSettings {
  int area_samples = 64;  ///< directions a cell gets from an extended light (disk, environment)
  std::uint64_t seed = 1;
};

/// Splits cells across which the light changes abruptly (the edge of a beam or a shadow) or that are
/// large against a projector's footprint, until no cell's flux is uncertain by more than
/// the mean flux of a cell of its object. Evenly lit cells stay as they are; on a coarse curved surface the cells
/// that turn away from the light are split too.
std::vector<SurfaceCells> refine_at_light_edges(const Scene& scene, const RayScene& rays,
                                                std::vector<SurfaceCells> cells, const IrradianceSettings& settings,
                                                Counters& counters);

/// E of the cells of one object: mean over the cell of sum over lights of V cos F_t(eta, cos) L.
/// Layout: values[(cell * etas + k) * channels + c]. With channels == 1 the RGB irradiance is
/// colour * value (all lights share one colour, so the three fields would be proportional).
struct IrradianceField {
  int etas = 1, channels = 1;
  Rgb colour{1};
  std::vector<float> values;
  /// Of every cell's four quarters (split_in_four), if asked for: quarters[(cell * 4 + quarter) * width() + k].
  std::vector<float> quarters{};
  int width() const { return etas * channels; }
};

/// One field per object; `eta_nodes[object]` lists its refraction indices (all lists equally long).
/// Four points of every cell are lit, with shadows; cells and lights that face away cost no ray.
std::vector<IrradianceField> compute_irradiance(const Scene& scene, const RayScene& rays,
                                                const std::vector<SurfaceCells>& cells,
                                                const std::vector<std::vector<double>>& eta_nodes,
                                                const IrradianceSettings& settings, Counters& counters,
                                                bool keep_quarters = false);

/// The same for some cells of one object, for its material's eta, with quarters. first_number: cells numbered below
/// it have had their light already (the directions towards an extended light depend on the number).
IrradianceField object_irradiance(const Scene& scene, const RayScene& rays, std::size_t object,
                                  const SurfaceCells& cells, std::size_t first_number,
                                  const IrradianceSettings& settings, Counters& counters);

}  // namespace opaline
