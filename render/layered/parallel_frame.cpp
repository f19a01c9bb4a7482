#include "render/layered/parallel_frame.h"

#include <algorithm>
#include <cmath>

namespace opaline {

ParallelFrame parallel_frame(const GBuffer& view, std::span<const glm::vec3> positions) {
  const Camera& camera = view.camera;
  const CameraFrame axes = camera_frame(camera);
  ParallelFrame frame;
  frame.origin = camera.position;
  frame.axes = glm::transpose(glm::dmat3(axes.right, -axes.up, axes.forward));
  frame.on_film = camera.type == Camera::Type::orthographic;
  if (frame.on_film) {
    frame.pixel = camera.height / view.height;
  } else {
    double depth = 0;
    for (const glm::vec3& p : positions) depth += frame.point(p).z;
    frame.pixel =
        2 * std::tan(camera.fov_y_deg * pi / 360) * depth / static_cast<double>(positions.size()) / view.height;
  }
  const glm::dvec2 half = 0.5 * frame.pixel * glm::dvec2(view.width, view.height);
  frame.film_lo = -half, frame.film_hi = half;
  frame.pixel_centre = glm::dvec2(0.5 * frame.pixel) - half;
  return frame;
}

FrameBox frame_box(const ParallelFrame& frame, std::span<const glm::vec3> positions) {
  FrameBox box;
  for (const glm::vec3& p : positions) box.add(frame.point(p));
  return box;
}

double projected_diameter(const ParallelFrame& frame, std::span<const glm::vec3> positions) {
  constexpr int directions = 32;  // the diameter is the largest width; the nearest direction is within pi / 64
  double lo[directions], hi[directions], cosine[directions], sine[directions];
  for (int i = 0; i < directions; ++i)
    cosine[i] = std::cos(pi * i / directions), sine[i] = std::sin(pi * i / directions);
  std::fill(lo, lo + directions, HUGE_VAL), std::fill(hi, hi + directions, -HUGE_VAL);
  for (const glm::vec3& p : positions) {
    const glm::dvec3 at = frame.point(p);
    for (int i = 0; i < directions; ++i) {
      const double along = cosine[i] * at.x + sine[i] * at.y;
      lo[i] = std::min(lo[i], along), hi[i] = std::max(hi[i], along);
    }
  }
  double widest = 0;
  for (int i = 0; i < directions; ++i) widest = std::max(widest, hi[i] - lo[i]);
  return widest / std::cos(pi / (2 * directions));
}

FrameGrid frame_grid(const ParallelFrame& frame, const FrameBox& box, double nodes_per_pixel, int max_nodes) {
  FrameGrid grid;
  grid.step = frame.pixel / nodes_per_pixel;
  const glm::dvec2 size = glm::dvec2(box.hi - box.lo);
  while (std::max(size.x, size.y) / grid.step + 3 > max_nodes) grid.step *= 2;
  grid.on_nodes = frame.on_film && grid.step <= frame.pixel;
  // Nodes lie at centres of pixels, or those of every second, fourth, ... pixel.
  const glm::dvec2 first = glm::floor((glm::dvec2(box.lo) - frame.pixel_centre) / grid.step - 1e-6);
  grid.corner = frame.pixel_centre + grid.step * first;
  const glm::dvec2 last = glm::floor((glm::dvec2(box.hi) - frame.pixel_centre) / grid.step + 1e-6);
  grid.width = static_cast<int>(last.x - first.x) + 2, grid.height = static_cast<int>(last.y - first.y) + 2;
  return grid;
}

}  // namespace opaline
