#include "model/cmd/transport_table.h"

#include "model/cmd/medium_options.h"
#include "model/profiles/model_error.h"
#include "model/profiles/transport_table.h"
#include "model/transport/transport_table_maker.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>

namespace opaline {
namespace {

/// Zeros at a row's end are written without digits: the file is an initialiser.
std::string to_text(const TransportTableCoefficients& table, const std::string& exit) {
  using Shape = TransportTableShape;
  std::string text = fmt::format(
      "// Made by `opaline transport table --exit {}`. The series Y of transport_table.h: rows by degree in eta, then\n"
      "// alpha'; in a row by degree in the radius. Whole numbers, in units of 1e-6.\n",
      exit);
  for (std::size_t row = 0; row < table.values.size(); row += Shape::radii) {
    const auto first = table.values.begin() + static_cast<std::ptrdiff_t>(row);
    text += fmt::format("{},\n", fmt::join(first, first + Shape::radii, ","));
  }
  return text;
}

/// Beside its place, then renamed. Throws if that cannot be done.
void write(const std::string& path, const std::string& text) {
  const std::string beside = path + ".part";
  std::ofstream(beside) << text << std::flush;
  std::error_code error;
  const bool whole = std::filesystem::file_size(beside, error) == text.size() && !error;
  if (whole) std::filesystem::rename(beside, path, error);
  require_argument(whole && !error, fmt::format("--out: \"{}\" cannot be written", path));
}

void check_writable(const std::string& path) {
  const std::string beside = path + ".part";
  const bool good = !std::filesystem::is_directory(path) && std::ofstream(beside).good();
  require_argument(good, fmt::format("--out: \"{}\" cannot be written", path));
  std::filesystem::remove(beside);
}

void make_table(const std::string& path, const std::string& exit) {
  check_writable(path);  // before the work
  const auto progress = [](std::size_t done, std::size_t all) { fmt::print(stderr, "eta {} of {}\n", done, all); };
  const TransportTableCoefficients table =
      make_transport_table(exit == "radiance_up" ? SearchlightExit::radiance_up : SearchlightExit::exitance, progress);
  write(path, to_text(table, exit));
  fmt::print(stderr, "worst residual of a fit: {:.2g} of the error expected\n", table.worst_residual);
}

/// One table for each eta: total reflectance, then shape.
void print_errors() {
  const std::vector<double> albedos = {.3, .5, .8, .9, .95, .99, .999};
  for (const double eta : {1.0, 1.3, 1.5}) {
    fmt::print("eta {}:\n\n| profile | {} |\n|---|", eta, fmt::join(albedos, " | "));
    for (std::size_t i = 0; i < albedos.size(); ++i) fmt::print("---|");
    fmt::print("\n");
    for (const ProfileInfo& model : profiles()) {
      if (model.name == "transport_table" || model.radiance || !model.needs_medium_alone()) continue;
      fmt::print("| {} |", model.name);
      for (const double albedo : albedos) {
        const ModelError e = model_error(model, albedo, eta);
        fmt::print(" {:+.1f} %, {:.2f} ({:+.2f}) |", 100 * e.total, e.shape, e.bias);
      }
      fmt::print("\n");
    }
    fmt::print("\n");
  }
}

}  // namespace

void add_transport_table_commands(CLI::App& transport) {
  const auto path = std::make_shared<std::string>();
  const auto exit = std::make_shared<std::string>("exitance");
  CLI::App* table = transport.add_subcommand(
      "table", "Makes the data of the profiles transport_table and transport_radiance (minutes)");
  table->add_option("--out", *path, "File to write")->required();
  table->add_option("--exit", *exit, "What of the light: exitance (transport_table), radiance_up (transport_radiance)")
      ->check(CLI::IsMember({"exitance", "radiance_up"}))
      ->capture_default_str();
  table->footer("Example: opaline transport table --out model/profiles/transport_table.inc");
  table->callback([path, exit] { make_table(*path, *exit); });

  CLI::App* errors = transport.add_subcommand(
      "errors",
      "Every profile against transport, by alpha': total reflectance and mean |log error| over .1 to 10 "
      "transport mean free paths (its bias in brackets), as Markdown");
  errors->footer("Example: opaline transport errors");
  errors->callback([] { print_errors(); });
}

}  // namespace opaline
