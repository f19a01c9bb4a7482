// One factor that a different exposure, unit or normalisation would explain, and what it doesn't explain.
#pragma once

#include "validate/metrics/metric.h"

namespace opaline {

/// The s that minimises sum (s i - r)^2; 1 for a black image.
inline double least_squares_scale(const Comparison& comparison) {
  const double ii = mean_of(comparison, [](double i, double) { return i * i; });
  const double ir = mean_of(comparison, [](double i, double r) { return i * r; });
  return ii > 0 ? ir / ii : 1;
}

}  // namespace opaline
