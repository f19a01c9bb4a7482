#include "validate/cmd/metric_limits.h"

#include "model/cmd/exit_status.h"
#include "render/input_error.h"
#include "validate/metrics/metric.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

namespace opaline {

MetricLimit parse_metric_limit(const std::string& option, const std::string& text, bool upper) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError(option, "", fmt::format("\"{}\" is not METRIC=NUMBER, as relative_rmse=0.01", text));
  MetricLimit limit{find_metric(text.substr(0, equals), option).name, 0, upper};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data() + equals + 1, end, limit.limit);
  if (error != std::errc() || stop != end || !std::isfinite(limit.limit))
    throw InputError(option, "", fmt::format("\"{}\" is not a finite number", text.substr(equals + 1)));
  return limit;
}

void check_metric_limits(const std::map<std::string, double>& values, const std::vector<MetricLimit>& limits) {
  std::string broken;
  for (const MetricLimit& limit : limits) {
    const auto it = values.find(limit.metric);
    if (it == values.end())
      throw InputError(limit.upper ? "--max" : "--min", "",
                       fmt::format("{} is not defined for the channels of these images", limit.metric));
    const bool holds = limit.upper ? std::abs(it->second) <= limit.limit : it->second >= limit.limit;
    if (!holds)
      broken += fmt::format("{}{} {:.6g} is {} the limit {:.6g}", broken.empty() ? "" : "; ", limit.metric, it->second,
                            limit.upper ? "above" : "below", limit.limit);
  }
  if (!broken.empty()) throw CommandFailed(broken);
}

}  // namespace opaline
