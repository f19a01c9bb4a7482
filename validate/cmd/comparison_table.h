// What `opaline compare` prints.
#pragma once

#include "validate/metrics/comparison.h"

#include <string>

namespace opaline {

/// {"metrics": {every metric, "per_channel"}, "pixels", "pixels_left_out", "coverage_mismatches"}.
std::string comparison_json(const Comparison& comparison);

/// A line for each metric: over all channels, and of each.
std::string comparison_table(const Comparison& comparison);

}  // namespace opaline
