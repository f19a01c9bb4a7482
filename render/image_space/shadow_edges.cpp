#include "render/image_space/shadow_edges.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Counts of marked pixels in any rectangle, from a table of sums.
class MarkedPixels {
 public:
  MarkedPixels(int width, int height)
      : width_(width), height_(height), sums_(static_cast<std::size_t>((width + 1) * (height + 1)), 0) {}
  void mark(int x, int y) { at(x + 1, y + 1) = 1; }
  void sum() {
    for (int y = 1; y <= height_; ++y)
      for (int x = 1; x <= width_; ++x) at(x, y) += at(x - 1, y) + at(x, y - 1) - at(x - 1, y - 1);
  }
  bool any_within(int x, int y, int radius) {
    const int x0 = std::max(x - radius, 0), y0 = std::max(y - radius, 0);
    const int x1 = std::min(x + radius + 1, width_), y1 = std::min(y + radius + 1, height_);
    return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0) > 0;
  }

 private:
  std::int32_t& at(int x, int y) { return sums_[static_cast<std::size_t>(y * (width_ + 1) + x)]; }
  int width_, height_;
  std::vector<std::int32_t> sums_;
};

float brightest(const ViewIrradiance& irradiance, std::size_t point) {
  const auto channels = static_cast<std::size_t>(irradiance.channels);
  const float* e = &irradiance.values[point * channels];
  return *std::max_element(e, e + channels);
}

}  // namespace

std::vector<std::uint8_t> near_light_edges(const GBuffer& view, const ViewIrradiance& irradiance, double radius) {
  const int width = view.width;
  float largest = 0;
  std::vector<std::int32_t> point_of(static_cast<std::size_t>(width * view.height), -1);
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    point_of[view.points[i].pixel] = static_cast<std::int32_t>(i);
    largest = std::max(largest, brightest(irradiance, i));
  }
  MarkedPixels edges(width, view.height);
  const auto compare = [&](std::size_t i, int x, int y, int dx, int dy) {
    if (x + dx >= width || y + dy >= view.height) return;
    const std::int32_t j = point_of[static_cast<std::size_t>((y + dy) * width + x + dx)];
    if (j < 0 || view.points[static_cast<std::size_t>(j)].object != view.points[i].object) return;
    if (std::abs(brightest(irradiance, i) - brightest(irradiance, static_cast<std::size_t>(j))) > 0.1f * largest)
      edges.mark(x, y);
  };
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const int x = static_cast<int>(view.points[i].pixel) % width, y = static_cast<int>(view.points[i].pixel) / width;
    compare(i, x, y, 1, 0);
    compare(i, x, y, 0, 1);
  }
  edges.sum();
  const Projection projection = projection_of(view.camera, width, view.height);
  std::vector<std::uint8_t> near(view.points.size());
  for (std::size_t i = 0; i < near.size(); ++i) {
    const int x = static_cast<int>(view.points[i].pixel) % width, y = static_cast<int>(view.points[i].pixel) / width;
    const float z = projection.point(view.points[i].position).z;
    const float pixels = static_cast<float>(radius) * projection.pixels_per_mm(z);
    near[i] = edges.any_within(x, y, static_cast<int>(std::min(std::ceil(pixels), 32767.0f)));
  }
  return near;
}

}  // namespace opaline
