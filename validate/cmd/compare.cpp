#include "render/cmd/render_arguments.h"
#include "render/input_error.h"
#include "validate/cmd/commands.h"
#include "validate/cmd/comparison_table.h"
#include "validate/cmd/metric_limits.h"
#include "validate/metrics/metric.h"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <optional>

namespace opaline {
namespace {

struct Arguments {
  std::string image, reference, mask, error_image;
  bool json = false, list = false;
  std::optional<double> max_rmse, max_relative_rmse;
  std::vector<std::string> max, min;
};

std::vector<MetricLimit> limits(const Arguments& a) {
  std::vector<MetricLimit> result;
  if (a.max_rmse) result.push_back({"rmse", *a.max_rmse, true});
  if (a.max_relative_rmse) result.push_back({"relative_rmse", *a.max_relative_rmse, true});
  for (const std::string& text : a.max) result.push_back(parse_metric_limit("--max", text, true));
  for (const std::string& text : a.min) result.push_back(parse_metric_limit("--min", text, false));
  return result;
}

void run(const Arguments& a) {
  check_output_path(a.error_image, ".exr");
  const std::vector<MetricLimit> checked = limits(a);
  const Image image = read_image(a.image), reference = read_image(a.reference);
  const Image mask = a.mask.empty() ? Image() : read_image(a.mask);
  Comparison comparison;
  try {
    comparison = compare_images(image, reference, a.mask.empty() ? nullptr : &mask);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} against {}", a.image, a.reference), "", error.what());
  }
  if (!a.error_image.empty()) write_exr(a.error_image, difference_image(comparison));
  fmt::print("{}", a.json ? comparison_json(comparison) : comparison_table(comparison));
  if (!checked.empty()) check_metric_limits(evaluate_metrics(comparison), checked);
}

void print_metrics(std::int64_t) {
  for (const Metric& metric : metrics()) fmt::print("{:<16}{}\n", metric.name, metric.formula);
  throw CLI::Success();  // ends parsing before the missing IMAGE is complained about
}

}  // namespace

void add_compare_command(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* compare = app.add_subcommand("compare", "Error metrics of an image against a reference");
  compare->add_option("IMAGE", a->image, "Image to judge")->required();
  compare->add_option("REFERENCE", a->reference, "Reference; its alpha, if any, says which pixels count")->required();
  compare->add_flag("--json", a->json, "JSON instead of a table");
  compare->add_flag("--list", print_metrics, "Show every metric with its formula")->trigger_on_parse();
  compare->add_option("--max", a->max, "METRIC=LIMIT: exit with 1 when its magnitude is above; may be repeated")
      ->allow_extra_args(false);
  compare->add_option("--min", a->min, "METRIC=LIMIT: exit with 1 when it is below, as psnr=40; may be repeated")
      ->allow_extra_args(false);
  compare->add_option("--max-rmse", a->max_rmse, "As --max rmse=LIMIT")->check(CLI::Range(0.0, HUGE_VAL));
  compare->add_option("--max-relative-rmse", a->max_relative_rmse, "As --max relative_rmse=LIMIT")
      ->check(CLI::Range(0.0, HUGE_VAL));
  compare->add_option("--mask", a->mask, "Image whose first channel is > 0 at the pixels that count");
  compare->add_option("--error-image", a->error_image, "Write image - reference, signed (.exr)");
  compare->footer("Example: opaline compare image.exr reference.exr --max relative_rmse=0.01 --json");
  compare->callback([a] { run(*a); });
}

}  // namespace opaline
