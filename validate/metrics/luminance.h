// One plane out of the compared channels, for metrics of what an eye sees.
#pragma once

#include "validate/metrics/comparison.h"

namespace opaline {

/// Rec. 709 luminance of linear R, G, B planes: 0.2126 R + 0.7152 G + 0.0722 B; a single plane as it is.
std::vector<double> luminance(const std::vector<std::vector<float>>& planes);

}  // namespace opaline
