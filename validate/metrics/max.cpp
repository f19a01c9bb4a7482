#include "validate/metrics/metric.h"

#include <algorithm>
#include <cmath>

namespace opaline {

Metric max_metric() {
  return {
      .name = "max", .formula = "largest |d|", .better = Metric::Better::lower, .evaluate = [](const Comparison& c) {
        double largest = 0;
        for_each_value(c, [&](double i, double r) { largest = std::max(largest, std::abs(i - r)); });
        return largest;
      }};
}

}  // namespace opaline
