#include "validate/metrics/metric.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

double evaluate(const Comparison& comparison) {
  std::vector<double> differences;
  for_each_value(comparison, [&](double i, double r) { differences.push_back(std::abs(i - r)); });
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * static_cast<double>(differences.size()))) - 1;
  std::nth_element(differences.begin(), differences.begin() + rank, differences.end());
  return differences[static_cast<std::size_t>(rank)];
}

}  // namespace

Metric p99_metric() {
  return {.name = "p99", .formula = "the least |d| that 99 % of the values don't exceed", .evaluate = evaluate};
}

}  // namespace opaline
