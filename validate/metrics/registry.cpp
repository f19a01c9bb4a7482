#include "render/choices.h"
#include "render/input_error.h"
#include "validate/metrics/metric.h"

#include <limits>

namespace opaline {

#define OPALINE_ROW(name) Metric name##_metric();
#include "metric_registry.inc"
#undef OPALINE_ROW

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> all = {
#define OPALINE_ROW(name) name##_metric(),
#include "metric_registry.inc"
#undef OPALINE_ROW
  };
  return all;
}

const Metric& find_metric(const std::string& name, const std::string& place) {
  std::vector<std::string> names;
  for (const Metric& metric : metrics()) {
    if (metric.name == name) return metric;
    names.push_back(metric.name);
  }
  throw InputError(place, "", unknown_choice("metric", name, names));
}

bool defined_for(const Metric& metric, const Comparison& comparison) {
  return !metric.needs_rgb || comparison.is_rgb() || comparison.channels.size() == 1;
}

std::map<std::string, double> evaluate_metrics(const Comparison& comparison) {
  std::map<std::string, double> values;
  for (const Metric& metric : metrics())
    if (defined_for(metric, comparison)) values[metric.name] = metric.evaluate(comparison);
  return values;
}

double ratio_or_infinite(double numerator, double denominator) {
  if (denominator > 0) return numerator / denominator;
  return numerator > 0 ? std::numeric_limits<double>::infinity() : 0.0;
}

}  // namespace opaline
