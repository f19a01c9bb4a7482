#include "validate/metrics/flip_difference.h"
#include "validate/metrics/metric.h"

namespace opaline {

Metric flip_metric() {
  return {
      .name = "flip",
      .formula =
          "mean HDR-FLIP (Andersson et al. 2021): the largest LDR-FLIP over exposures of ACES, 67 pixels per degree",
      .needs_rgb = true,
      .evaluate = [](const Comparison& c) { return mean_over_compared(c, hdr_flip(c)); }};
}

}  // namespace opaline
