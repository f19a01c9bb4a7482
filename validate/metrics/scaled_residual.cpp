#include "validate/metrics/least_squares_scale.h"

#include <cmath>

namespace opaline {
namespace {

double evaluate(const Comparison& comparison) {
  const double s = least_squares_scale(comparison);
  const double squares = mean_of(comparison, [s](double i, double r) { return (s * i - r) * (s * i - r); });
  return std::sqrt(ratio_or_infinite(squares, mean_of(comparison, [](double, double r) { return r * r; })));
}

}  // namespace

Metric scaled_residual_metric() {
  return {
      .name = "scaled_residual",
      .formula = "sqrt(mean (s i - r)^2 / mean r^2) with the scale_factor s: the relative_rmse that no exposure mends",
      .evaluate = evaluate};
}

}  // namespace opaline
