// Limits of metrics on the command line: --max relative_rmse=0.01, --min psnr=40.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace opaline {

struct MetricLimit {
  std::string metric;
  double limit = 0;
  bool upper = true;  ///< |value| <= limit, else value >= limit
};

/// Reads NAME=NUMBER; InputError (`option`) for another form or a metric that doesn't exist.
MetricLimit parse_metric_limit(const std::string& option, const std::string& text, bool upper);

/// Throws CommandFailed naming every limit that is broken, with the value. InputError for a metric without a value.
void check_metric_limits(const std::map<std::string, double>& values, const std::vector<MetricLimit>& limits);

}  // namespace opaline
