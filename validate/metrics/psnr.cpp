#include "validate/metrics/metric.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

double evaluate(const Comparison& comparison) {
  double peak = 0;
  for_each_value(comparison, [&](double, double r) { peak = std::max(peak, std::abs(r)); });
  const double mse = mean_of(comparison, [](double i, double r) { return (i - r) * (i - r); });
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (mse == 0) return infinite;
  return peak > 0 ? 10 * std::log10(peak * peak / mse) : -infinite;
}

}  // namespace

Metric psnr_metric() {
  return {
      .name = "psnr",
      .formula = "20 log10(peak / rmse) [dB], peak the largest |r|; infinite without error, -infinite against black",
      .better = Metric::Better::higher,
      .evaluate = evaluate};
}

}  // namespace opaline
