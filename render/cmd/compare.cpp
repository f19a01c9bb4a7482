#include "render/cmd/commands.h"
#include "render/cmd/exit_status.h"
#include "render/cmd/render_arguments.h"
#include "render/image_difference.h"
#include "render/input_error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <memory>
#include <optional>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;
constexpr double no_limit = std::numeric_limits<double>::infinity();

struct Arguments {
  std::string image, reference, mask, error_image;
  bool json = false;
  std::optional<double> max_rmse, max_relative_rmse;
};

/// JSON has no infinity: null stands for the relative error against a black reference.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json to_json(const DifferenceMetrics& m) {
  return {{"rmse", m.rmse}, {"relative_rmse", finite(m.relative_rmse)}, {"mean_error", m.mean_error}, {"max", m.max}};
}

void print_json(const ImageDifference& d) {
  Json metrics = to_json(d.overall);
  for (std::size_t c = 0; c < d.channels.size(); ++c) metrics["per_channel"][d.channels[c]] = to_json(d.channel[c]);
  const Json json = {{"metrics", metrics},
                     {"pixels", d.pixels},
                     {"pixels_left_out", d.pixels_left_out},
                     {"coverage_mismatches", d.coverage_mismatches}};
  fmt::print("{}\n", json.dump(2));
}

void print_row(const std::string& name, const DifferenceMetrics& m) {
  fmt::print("{:<8} {:>12.5g} {:>14.5g} {:>12.5g} {:>12.5g}\n", name, m.rmse, m.relative_rmse, m.mean_error, m.max);
}

void print_table(const ImageDifference& d) {
  fmt::print("{:<8} {:>12} {:>14} {:>12} {:>12}\n", "channel", "rmse", "relative_rmse", "mean_error", "max");
  for (std::size_t c = 0; c < d.channels.size(); ++c) print_row(d.channels[c], d.channel[c]);
  print_row("all", d.overall);
  fmt::print("{} pixels compared, {} left out by the reference's alpha or the mask\n", d.pixels, d.pixels_left_out);
  if (d.coverage_mismatches > 0)
    fmt::print("{} pixels are covered in one image and not in the other\n", d.coverage_mismatches);
}

void check_limit(const char* metric, double value, const std::optional<double>& limit) {
  if (limit && !(value <= *limit))
    throw CommandFailed(fmt::format("{} {} is above the limit {}", metric, value, *limit));
}

void run(const Arguments& a) {
  check_output_path(a.error_image, ".exr");
  const Image image = read_image(a.image), reference = read_image(a.reference);
  const Image mask = a.mask.empty() ? Image() : read_image(a.mask);
  const Image* chosen = a.mask.empty() ? nullptr : &mask;
  ImageDifference difference;
  try {
    difference = compare_images(image, reference, chosen);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{} against {}", a.image, a.reference), "", error.what());
  }
  if (!a.error_image.empty()) write_exr(a.error_image, difference_image(image, reference, chosen));
  a.json ? print_json(difference) : print_table(difference);
  check_limit("rmse", difference.overall.rmse, a.max_rmse);
  check_limit("relative_rmse", difference.overall.relative_rmse, a.max_relative_rmse);
}

}  // namespace

void add_compare_command(CLI::App& app) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* compare = app.add_subcommand("compare", "Error metrics of an image against a reference");
  compare->add_option("IMAGE", a->image, "Image to judge")->required();
  compare->add_option("REFERENCE", a->reference, "Reference; its alpha, if any, says which pixels count")->required();
  compare->add_flag("--json", a->json, "JSON instead of a table");
  compare->add_option("--max-rmse", a->max_rmse, "Exit with 1 when the rmse is above this")
      ->check(CLI::Range(0.0, no_limit));
  compare
      ->add_option("--max-relative-rmse", a->max_relative_rmse, "Exit with 1 when rmse / rms(reference) is above this")
      ->check(CLI::Range(0.0, no_limit));
  compare->add_option("--mask", a->mask, "Image whose first channel is > 0 at the pixels that count");
  compare->add_option("--error-image", a->error_image, "Write image - reference, signed (.exr)");
  compare->footer("Example: opaline compare image.exr reference.exr --max-relative-rmse 0.01 --json");
  compare->callback([a] { run(*a); });
}

}  // namespace opaline
