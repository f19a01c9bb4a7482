// One object's work on one grid: what the processor and the GPU both carry out. Everything that depends on the scene is
// decided here; a backend transforms, multiplies, transforms back and looks up the visible points.
#pragma once

#include "render/layered/convolve.h"
#include "render/layered/layered_settings.h"
#include "render/layered/splat.h"

#include <array>

namespace opaline {

/// A visible point on the grid: node coordinates and layers.
struct LayerPoint {
  float x, y;
  Layers::Place z;
};

/// One profile applied to one channel of the irradiance.
struct LayerLane {
  KernelTable table;
  /// outputs[0] is exitance. With near=surface outputs[1] and [2] are what the near part of the profile makes of the
  /// flux and of the area of the surface that faces the viewer; their ratio, times near_total, is added.
  std::vector<std::vector<OutputLayer>> outputs;
  float near_total = 0;
  GridAxis x_axis, y_axis;
  std::array<bool, 3> colours{};  ///< which channels of the picture it serves
};

struct LayeredPass {
  FrameGrid grid;
  int width = 0, height = 0;  ///< of the transforms: the grid and room for the kernel
  float scale = 1;            ///< of every product
  Layers layers;
  LayerSources sources;
  std::vector<LayerPoint> points;
  std::vector<LayerLane> lanes;
};

/// Exitance over the light's colour, per point, of one lane. Transforms the sources in place at the first lane.
class LayeredBackend {
 public:
  virtual ~LayeredBackend() = default;
  /// One list of values per lane.
  virtual std::vector<std::vector<float>> run(LayeredPass& pass) = 0;
};

class LayeredCpu : public LayeredBackend {
 public:
  std::vector<std::vector<float>> run(LayeredPass& pass) override;
};

/// The exitance of a point from what the lane's outputs are there.
inline float lane_value(const LayerLane& lane, const float* outputs) {
  if (lane.outputs.size() == 1) return outputs[0];
  return outputs[0] + (outputs[2] > 0 ? lane.near_total * outputs[1] / outputs[2] : 0);
}

}  // namespace opaline
