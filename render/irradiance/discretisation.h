// Cells fine enough for one material: the part of the reference's error that no tree can see.
//
// A cell has one irradiance, the mean of its four quarters. What that leaves out is estimated by a second placement:
// the exitance of the quarters, each with its own irradiance, against that of the cells, at points all over the
// surface. Quarters are wrong by a quarter of it where light is smooth and by half of it at its edges, so the estimate
// is 4/3 of the difference, or twice it. Where it is above the tolerance and the quarters are good enough, they are the
// cells, at no further cost; else the cells whose irradiance varies most are split, and so on. A narrow profile needs
// finer cells than a wide one in the same light.
#pragma once

#include "render/irradiance/profile_gather.h"

namespace opaline {

struct DiscretisationSettings {
  double max_relative_error = 1e-3;   ///< of the exitance over the whole surface, RMS over RMS, in every channel
  std::size_t max_cells = 4'000'000;  ///< of one object: no cell is split beyond it
  int max_rounds = 8;
};

/// One object, ready for a gather.
struct Discretisation {
  SurfaceCells cells;
  IrradianceField irradiance;
  ClusterTree tree;
  double error = 0;  ///< estimated, as max_relative_error is meant; 0 where nothing is lit
  int rounds = 0;    ///< how often cells were split, or replaced by their quarters
};

/// The cells given, or finer ones. `irradiance` has quarters (compute_irradiance). Counts: discretisation_points,
/// discretisation_rounds, cells_added_by_discretisation; skipped: discretisation_estimates where no cell's light
/// varies, cells_beyond_limit, splits that max_cells forbade. The points are the same for any view: an edit of the
/// camera asks for no new cells.
Discretisation discretise(const Scene& scene, const RayScene& rays, std::size_t object, const SurfaceCells& cells,
                          const IrradianceField& irradiance, const ChannelProfiles& profiles,
                          const IrradianceSettings& light, const DiscretisationSettings& settings, Counters& counters);

}  // namespace opaline
