// The frame in which the layers of an object are parallel planes, and the grid on them.
//
// Layers are orthogonal to the camera's axis and all have one scale, so projection into them is parallel: along the
// axis, whatever the camera. For an orthographic camera that is the film itself. For a perspective one it is a stated
// choice: only places are projected so, what is visible and where it is on the film stays the camera's, and no length
// is distorted (a scale per layer would make the convolutions between layers depend on place).
#pragma once

#include "render/visibility/gbuffer.h"

#include <span>

namespace opaline {

/// Coordinates [mm]: x of the film to the right, y down, z along the camera's axis.
struct ParallelFrame {
  glm::dvec3 origin{0};
  glm::dmat3 axes{1};          ///< from world to frame
  double pixel = 1;            ///< side of the film's pixel on the layers [mm]
  glm::dvec2 pixel_centre{0};  ///< place of the centre of one of them
  glm::dvec2 film_lo{0}, film_hi{0};
  bool on_film = false;  ///< visible points are at centres of pixels: orthographic

  glm::dvec3 point(const glm::vec3& world) const { return axes * (glm::dvec3(world) - origin); }
};

/// `positions`: the visible points of the object, at least one; the pixel of a perspective camera is taken at their
/// mean depth.
ParallelFrame parallel_frame(const GBuffer& view, std::span<const glm::vec3> positions);

/// A box in a frame [mm].
struct FrameBox {
  glm::dvec3 lo{HUGE_VAL}, hi{-HUGE_VAL};
  void add(const glm::dvec3& p) { lo = glm::min(lo, p), hi = glm::max(hi, p); }
};
FrameBox frame_box(const ParallelFrame& frame, std::span<const glm::vec3> positions);

/// Largest distance between two of the positions as seen along the frame's axis [mm], at most .2 % too large.
double projected_diameter(const ParallelFrame& frame, std::span<const glm::vec3> positions);

/// Nodes at equal steps in x and y.
struct FrameGrid {
  double step = 1;       ///< [mm]
  glm::dvec2 corner{0};  ///< place of node (0, 0)
  int width = 1, height = 1;
  bool on_nodes = false;  ///< visible points are at nodes

  double x(double mm) const { return (mm - corner.x) / step; }
  double y(double mm) const { return (mm - corner.y) / step; }
};

/// The grid with `nodes_per_pixel` (a power of two) that covers the box in x and y, with a node to spare all round.
/// A side gets at most `max_nodes`: the step grows by powers of two where it would be more.
FrameGrid frame_grid(const ParallelFrame& frame, const FrameBox& box, double nodes_per_pixel, int max_nodes);

}  // namespace opaline
