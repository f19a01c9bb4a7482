#include "validate/metrics/metric.h"

namespace opaline {

Metric mean_error_metric() {
  return {.name = "mean_error",
          .formula = "mean d: > 0 where the image is too bright",
          .better = Metric::Better::zero,
          .evaluate = [](const Comparison& c) { return mean_of(c, [](double i, double r) { return i - r; }); }};
}

}  // namespace opaline
