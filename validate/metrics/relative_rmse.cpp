#include "validate/metrics/metric.h"

#include <cmath>

namespace opaline {

Metric relative_rmse_metric() {
  return {.name = "relative_rmse",
          .formula = "sqrt(mean d^2 / mean r^2); 0 / 0 is 0, and an error against black infinite",
          .better = Metric::Better::lower,
          .evaluate = [](const Comparison& c) {
            const double squares = mean_of(c, [](double i, double r) { return (i - r) * (i - r); });
            return std::sqrt(ratio_or_infinite(squares, mean_of(c, [](double, double r) { return r * r; })));
          }};
}

}  // namespace opaline
