// Where the error of cells is looked at, and how the light varies within them.
#pragma once

#include "render/irradiance/irradiance.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace opaline {

/// How much the irradiance of a cell's quarters differs from the cell's, in the channel where it differs most.
inline float light_spread(const IrradianceField& field, std::size_t cell) {
  const auto width = static_cast<std::size_t>(field.width());
  float largest = 0;
  for (std::size_t q = 0; q < 4; ++q)
    for (std::size_t m = 0; m < width; ++m)
      largest =
          std::max(largest, std::abs(field.quarters[(4 * cell + q) * width + m] - field.values[cell * width + m]));
  return largest;
}

inline float brightest_light(const IrradianceField& field, std::size_t cell) {
  const auto width = static_cast<std::ptrdiff_t>(field.width());
  const auto first = field.values.begin() + static_cast<std::ptrdiff_t>(cell) * width;
  return *std::max_element(first, first + width);
}

/// Points of the surface, a third of them by area, a third by flux and a third by where the irradiance varies within
/// its cells: a beam or an edge that covers little of the surface is met too.
struct Probes {
  std::vector<glm::vec3> positions;
  std::vector<double> weights;  ///< one over the density: a weighted sum is an integral over the surface
};

/// At most 384; the field has quarters. The same cells and light give the same points.
Probes make_probes(const SurfaceCells& cells, const IrradianceField& field);

}  // namespace opaline
