#include "validate/metrics/metric.h"

namespace opaline {

Metric relmse_metric() {
  return {.name = "relmse",
          .formula = "mean d^2 / (r^2 + 0.01), values in the images' units (Rousselle, Knaus, Zwicker 2011)",
          .better = Metric::Better::lower,
          .evaluate = [](const Comparison& c) {
            return mean_of(c, [](double i, double r) { return (i - r) * (i - r) / (r * r + 0.01); });
          }};
}

}  // namespace opaline
