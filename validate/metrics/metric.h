// Error metrics: how far an image is from its reference, as one number each.
//
// A metric is one <name>.cpp in this folder and one line in CMakeLists.txt; `opaline compare`, every record and every
// gate know it from then on. Below, i is a value of the image, r of the reference, d = i - r, and means run over all
// compared pixels and channels as one set, unless the metric says otherwise.
#pragma once

#include "validate/metrics/comparison.h"

#include <map>
#include <string>
#include <vector>

namespace opaline {

struct Metric {
  std::string name;     ///< as in JSON: "relative_rmse"
  std::string formula;  ///< one line with every constant, and the source where there is one
  enum class Better { lower, higher, zero, one } better = Better::lower;
  bool needs_rgb = false;  ///< defined for R, G and B (a single channel counts as grey), not for other sets of channels
  /// Finite, but for the cases that the formula names as infinite; never NaN.
  double (*evaluate)(const Comparison& comparison) = nullptr;
};

/// All registered metrics, in the order of CMakeLists.txt.
const std::vector<Metric>& metrics();

/// InputError naming the valid ones (`place` says who asked) if there is none of that name.
const Metric& find_metric(const std::string& name, const std::string& place);

bool defined_for(const Metric& metric, const Comparison& comparison);

/// Every metric that is defined for the compared channels, by name.
std::map<std::string, double> evaluate_metrics(const Comparison& comparison);

/// Calls visit(double image, double reference) for every compared value, channel by channel.
template <typename Visit>
void for_each_value(const Comparison& comparison, const Visit& visit) {
  for (std::size_t k = 0; k < comparison.channels.size(); ++k)
    for (const std::size_t p : comparison.pixels)
      visit(static_cast<double>(comparison.image[k][p]), static_cast<double>(comparison.reference[k][p]));
}

/// Mean of term(image, reference) over every compared value.
template <typename Term>
double mean_of(const Comparison& comparison, const Term& term) {
  double sum = 0;
  for_each_value(comparison, [&](double i, double r) { sum += term(i, r); });
  return sum / static_cast<double>(comparison.pixels.size() * comparison.channels.size());
}

/// numerator / denominator; 0 / 0 is 0, and anything else / 0 infinite.
double ratio_or_infinite(double numerator, double denominator);

}  // namespace opaline
