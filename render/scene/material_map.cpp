#include "render/scene/material_map.h"

#include <algorithm>
#include <functional>

namespace opaline {
namespace {

/// fold(so far, value) over the texels of the map's three channels.
glm::dvec3 over_texels(const Image& image, double start, const std::function<double(double, double)>& fold) {
  glm::dvec3 result(start);
  const auto channels = image.channels.size();
  for (std::size_t p = 0; p < image.pixel_count(); ++p)
    for (int c = 0; c < 3; ++c) {
      const auto which = channels == 1 ? std::size_t{0} : static_cast<std::size_t>(c);
      result[c] = fold(result[c], static_cast<double>(image.data[p * channels + which]));
    }
  return result;
}

}  // namespace

glm::dvec3 MaterialMap::at(const glm::vec2& uv) const {
  float value[3];
  const bool grey = texture.image->channel_count() == 1;
  texture.sample(uv, grey ? 1 : 3, value);
  return scale * (grey ? glm::dvec3(value[0]) : glm::dvec3(value[0], value[1], value[2]));
}

glm::dvec3 MaterialMap::smallest() const {
  return scale * over_texels(*texture.image, 1e300, [](double a, double b) { return std::min(a, b); });
}

glm::dvec3 MaterialMap::largest() const {
  return scale * over_texels(*texture.image, 0, [](double a, double b) { return std::max(a, b); });
}

glm::dvec3 MaterialMap::mean() const {
  return scale * over_texels(*texture.image, 0, [](double a, double b) { return a + b; }) /
         static_cast<double>(texture.image->pixel_count());
}

}  // namespace opaline
