#include "validate/metrics/metric.h"

#include <cmath>

namespace opaline {

Metric rmse_metric() {
  return {.name = "rmse",
          .formula = "sqrt(mean d^2)",
          .better = Metric::Better::lower,
          .evaluate = [](const Comparison& c) {
            return std::sqrt(mean_of(c, [](double i, double r) { return (i - r) * (i - r); }));
          }};
}

}  // namespace opaline
