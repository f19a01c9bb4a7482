#include "validate/cmd/comparison_table.h"

#include "validate/metrics/metric.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// JSON has no infinity: null stands for the relative error against a black reference, or the PSNR of equal images.
Json to_json(const Comparison& c) {
  Json values = Json::object();
  for (const Metric& metric : metrics()) {
    if (!defined_for(metric, c)) continue;
    const double value = metric.evaluate(c);
    values[metric.name] = std::isfinite(value) ? Json(value) : Json();
  }
  return values;
}

}  // namespace

std::string comparison_json(const Comparison& c) {
  Json values = to_json(c);
  for (std::size_t k = 0; k < c.channels.size(); ++k) values["per_channel"][c.channels[k]] = to_json(c.channel(k));
  const Json json = {{"metrics", values},
                     {"pixels", c.pixels.size()},
                     {"pixels_left_out", c.pixels_left_out},
                     {"coverage_mismatches", c.coverage_mismatches}};
  return json.dump(2) + "\n";
}

std::string comparison_table(const Comparison& c) {
  std::string text;
  text += fmt::format("{:<16}{:>12}", "metric", "all");
  for (const std::string& channel : c.channels) text += fmt::format("{:>12}", channel);
  text += "\n";
  for (const Metric& metric : metrics()) {
    if (!defined_for(metric, c)) continue;
    text += fmt::format("{:<16}{:>12.5g}", metric.name, metric.evaluate(c));
    for (std::size_t k = 0; k < c.channels.size(); ++k) text += fmt::format("{:>12.5g}", metric.evaluate(c.channel(k)));
    text += "\n";
  }
  text += fmt::format("{} pixels compared, {} left out by the reference's alpha or the mask\n", c.pixels.size(),
                      c.pixels_left_out);
  if (c.coverage_mismatches > 0)
    text += fmt::format("{} pixels are covered in one image and not in the other\n", c.coverage_mismatches);
  return text;
}

}  // namespace opaline
