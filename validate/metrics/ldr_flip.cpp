#include "validate/metrics/flip_difference.h"
#include "validate/metrics/metric.h"

namespace opaline {

Metric ldr_flip_metric() {
  return {.name = "ldr_flip",
          .formula = "mean LDR-FLIP (Andersson et al. 2020) of linear values clipped to [0, 1], 67 pixels per degree",
          .needs_rgb = true,
          .evaluate = [](const Comparison& c) { return mean_over_compared(c, ldr_flip(c)); }};
}

}  // namespace opaline
