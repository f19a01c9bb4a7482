#include "render/scene/layered_medium.h"

#include <algorithm>

namespace opaline {
namespace {

/// What the textures say, made to grow.
void ordered(float* depth, int count, double scale) {
  float above = 0;
  for (int k = 0; k < count; ++k) above = depth[k] = std::max(depth[k] * static_cast<float>(scale), above);
}

}  // namespace

void LayeredMedium::boundaries(const glm::vec2& uv, float* out) const {
  for (int first = 0; first < count(); first += 4)
    depths[static_cast<std::size_t>(first / 4)].sample(uv, std::min(4, count() - first), out + first);
  ordered(out, count(), depth_scale);
}

std::vector<double> LayeredMedium::largest_thickness() const {
  std::vector<double> thickness(layers.size(), 0);
  // At the texels of the first texture; others of another size are read between theirs.
  const Image& grid = *depths.front().image;
  float depth[most_layers];
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const glm::vec2 uv((static_cast<float>(x) + 0.5f) / static_cast<float>(grid.width),
                         (static_cast<float>(y) + 0.5f) / static_cast<float>(grid.height));
      boundaries(uv, depth);
      for (std::size_t k = 0; k < layers.size(); ++k)
        thickness[k] = std::max(thickness[k], static_cast<double>(depth[k] - (k > 0 ? depth[k - 1] : 0)));
    }
  return thickness;
}

double LayeredMedium::largest_depth() const {
  double largest = 0;
  for (int k = 0; k < count(); ++k) {
    const Image& image = *depths[static_cast<std::size_t>(k / 4)].image;
    for (std::size_t p = 0; p < image.pixel_count(); ++p)
      largest = std::max(largest,
                         static_cast<double>(image.data[p * image.channels.size() + static_cast<std::size_t>(k % 4)]));
  }
  return largest * depth_scale;
}

}  // namespace opaline
