// A suite: which cells `opaline validate` measures. One JSON file; validate.md says what each key means and
// suites/suite.schema.json is its JSON Schema.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

using SettingValues = std::map<std::string, std::string>;

/// A material by name, as a value of a scene's "materials": {"library": "skin1"}, or coefficients.
struct SuiteMaterial {
  std::string name;
  nlohmann::json value;
};

struct SuiteScene {
  std::string name;                      ///< letters, digits, "_" and "-"
  std::string path;                      ///< anchors relative paths in the document, and names it in messages
  nlohmann::json document;               ///< a scene document
  std::vector<SuiteMaterial> materials;  ///< one after the other for all objects; none: the scene's own
  std::string dataset;                   ///< of layers (layered_datasets.h), whose depths a run writes; else empty
};

struct SuiteTruth {
  SettingValues settings;           ///< of path_traced
  std::vector<std::string> scenes;  ///< those that get it; empty: all
};

struct Suite {
  std::string path, name, summary;
  std::vector<SuiteScene> scenes;
  std::vector<std::string> techniques;  ///< empty: every one that is registered
  std::vector<std::string> backends = {"cpu", "gpu"};
  std::map<std::string, std::vector<SettingValues>> sweeps;  ///< by technique; without: one cell of its defaults
  std::vector<std::string> edits;                            ///< of "camera", "light", "material", "geometry"
  std::size_t samples = 20000;                               ///< surface cells
  int light_samples = 64;
  std::uint64_t seed = 1;
  int runs = 3;            ///< measurements of each time, at least
  double max_seconds = 5;  ///< no measurement is repeated beyond this
  SettingValues reference = {{"max_relative_error", "3e-4"}};
  SettingValues layered_reference;  ///< of single_scatter_exact, where materials have layers
  std::optional<SuiteTruth> truth;
  bool images = true;  ///< are the rendered images kept?
};

/// Throws InputError naming file, place and valid choices. Techniques and their settings are checked, scenes are not
/// read further than their own file.
Suite parse_suite(const nlohmann::json& document, const std::string& path);

/// The suites that are built in (suites/*.json), by name: "quick", "default", "full".
std::vector<std::string> shipped_suite_names();

/// The built-in suite of that name, or the file if `name_or_file` ends in ".json".
Suite find_suite(const std::string& name_or_file);

}  // namespace opaline
