#include "validate/metrics/least_squares_scale.h"

namespace opaline {

Metric scale_factor_metric() {
  return {.name = "scale_factor",
          .formula = "the s that minimises sum (s i - r)^2: mean(i r) / mean(i^2); 1 for a black image",
          .better = Metric::Better::one,
          .evaluate = least_squares_scale};
}

}  // namespace opaline
