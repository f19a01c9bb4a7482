// Where on the film is an edge of light near? There the importance samples of a dark point rarely meet light, and
// the uniform set is worth its samples.
#pragma once

#include "render/image_space/irradiance_map.h"

#include <cstdint>
#include <vector>

namespace opaline {

/// One byte per point of the view: 1 where, within `radius` mm of it on the film, the irradiance of the same object
/// changes from a pixel to the next by more than a tenth of its largest value.
std::vector<std::uint8_t> near_light_edges(const GBuffer& view, const ViewIrradiance& irradiance, double radius);

}  // namespace opaline
