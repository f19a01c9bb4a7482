// The light of an object's surface cells, distributed onto its layers: front and back of every part, none hidden.
//
// A cell's flux is shared by its pieces, each smaller than the grid's step (or half of it), and a piece's flux by the
// four nodes and the two layers around it. So the flux on the layers is that of the surface, whatever the step and the
// view.
#pragma once

#include "render/irradiance/irradiance.h"
#include "render/layered/fft.h"
#include "render/layered/layers.h"
#include "render/layered/parallel_frame.h"

namespace opaline {

struct SplatSettings {
  bool half = false;    ///< half to each of the two layers (the paper), else by depth
  bool facing = false;  ///< surface that faces the viewer apart from the rest, and its area
  float piece = 1;      ///< side of the pieces of a cell, at most, in steps of the grid
};

/// What is on the layers, one stack each: flux [E mm^2] per channel of the irradiance, then, by facing, that of the
/// surface turned away, then the area [mm^2] of the surface that faces the viewer.
struct LayerSources {
  std::vector<LayerStack> stacks;
  std::vector<std::vector<std::uint8_t>> lit;  ///< per stack and layer: is anything there?
  std::size_t cells = 0, dark_cells = 0, cells_outside = 0, pieces = 0;
  bool any(int layer) const {
    for (const auto& l : lit)
      if (l[static_cast<std::size_t>(layer)]) return true;
    return false;
  }
};

/// width, height: of the stacks, at least those of the grid; what is beyond the grid is 0.
LayerSources splat_cells(const SurfaceCells& cells, const IrradianceField& field, const ParallelFrame& frame,
                         const FrameGrid& grid, int width, int height, const Layers& layers,
                         const SplatSettings& settings);

}  // namespace opaline
