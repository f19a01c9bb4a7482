// A recipe: everything a synthetic dataset is made from. One JSON file is one dataset; recipe.md
// beside the shipped ones says what each key means.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace opaline {

struct Recipe {
  std::string path;              ///< file it came from; anchors the scene's relative paths
  std::string name;              ///< letters, digits, "_" and "-"
  std::string summary;           ///< one line
  nlohmann::json scene;          ///< a scene document with the true material; read when the dataset is made
  std::string material;          ///< key of the scene's "materials": the one to be fitted
  double noise_relative = 0;     ///< standard deviation / RMS of the channel over the object's pixels, 0 .. 10
  std::uint64_t seed = 1;        ///< of the noise and of the light samples, 0 .. 2^31 - 1
  int starts = 8;                ///< a fit should start from, 1 .. 10000
  std::size_t samples = 100000;  ///< surface cells, 1 .. 10^8
  std::string technique;
  std::map<std::string, std::string> settings;  ///< of the technique
};

/// Reads {"format": "opaline-recipe", "version": 1, "name", "summary", "scene", "material", "noise":
/// {"relative"}, "seed", "starts", "samples", "technique", "settings"}; only "settings" may be left
/// out. Throws InputError naming file, place and valid choices; the scene itself and the technique
/// are checked by make_dataset.
Recipe parse_recipe(const nlohmann::json& document, const std::string& path);

/// As parse_recipe, from a file.
Recipe load_recipe(const std::string& path);

/// The recipes that are built in (recipes/*.json), in the order of their names.
const std::vector<Recipe>& shipped_recipes();

/// The built-in recipe of that name, or the file if `name_or_file` ends in ".json". Throws
/// InputError naming the built-in ones.
Recipe find_recipe(const std::string& name_or_file);

}  // namespace opaline
