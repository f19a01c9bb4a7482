#include "model/cmd/commands.h"
#include "model/materials/library.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <memory>
#include <stdexcept>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// Adds `key` unless the source gives no value.
void add_known(Json& json, const char* key, const std::array<double, 3>& values) {
  if (!std::isnan(values[0])) json[key] = values;
}

Json to_json(const MaterialRow& row) {
  Json json = {{"name", row.name},
               {"set", row.set},
               {"sigma_a_per_mm", row.sigma_a},
               {"sigma_s_prime_per_mm", row.sigma_s_prime},
               {"eta", row.eta}};
  add_known(json, "g", row.g);
  add_known(json, "sigma_s_per_mm", row.sigma_s);
  add_known(json, "published_rd", row.published_rd);
  json["source"] = row.source;
  return json;
}

void list_materials(bool as_json) {
  if (as_json) {
    Json rows = Json::array();
    for (const MaterialRow& row : material_library()) rows.push_back(to_json(row));
    fmt::print("{}\n", rows.dump(2));
    return;
  }
  fmt::print("{:<30} {:<16} {:<32} {:<32} eta\n", "name", "set", "sigma_a [1/mm]", "sigma_s' [1/mm]");
  for (const MaterialRow& row : material_library()) {
    fmt::print("{:<30} {:<16} {:<32} {:<32} {}\n", row.name, row.set, fmt::format("{}", fmt::join(row.sigma_a, " ")),
               fmt::format("{}", fmt::join(row.sigma_s_prime, " ")), row.eta);
  }
}

void show_material(const std::string& name, bool as_json) {
  const MaterialRow* row = find_material(name);
  if (row == nullptr) {
    throw std::invalid_argument(
        fmt::format("NAME: no material \"{}\"; the library has {}", name, fmt::join(material_names(), ", ")));
  }
  const Json json = to_json(*row);
  if (as_json) {
    fmt::print("{}\n", json.dump(2));
    return;
  }
  for (const auto& [key, value] : json.items()) {
    fmt::print("{:<21} {}\n", key, value.is_string() ? value.get<std::string>() : value.dump());
  }
}

}  // namespace

void add_material_command(CLI::App& app) {
  CLI::App* material = app.add_subcommand("material", "Measured materials: list them, show one, export, import");
  material->require_subcommand(1);
  material->footer("Example: opaline material show wholemilk --json");

  const auto as_json = std::make_shared<bool>(false);
  CLI::App* list = material->add_subcommand("list", "All materials");
  list->add_flag("--json", *as_json, "JSON instead of a table");
  list->footer("Example: opaline material list");
  list->callback([as_json] { list_materials(*as_json); });

  const auto name = std::make_shared<std::string>();
  CLI::App* show = material->add_subcommand("show", "One material, with its source");
  show->add_option("NAME", *name, "Name; case, spaces and underscores don't matter")->required();
  show->add_flag("--json", *as_json, "JSON instead of text");
  show->footer("Example: opaline material show \"Head & Shoulders Shampoo\"");
  show->callback([name, as_json] { show_material(*name, *as_json); });
  add_material_exchange(*material);
}

}  // namespace opaline
