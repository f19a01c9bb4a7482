#include "datasets_synthetic/recipe.h"

#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

namespace opaline {
namespace {

struct EmbeddedRecipe {
  const char *name, *text;
};

constexpr EmbeddedRecipe embedded[] = {
#include "recipes.inc"
};

void check_format(JsonObject& json) {
  json.choice("format", {"opaline-recipe"});
  json.integer("version", 1, 1);
}

std::string read_name(JsonObject& json) {
  std::string name = json.text("name");
  const auto good = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), good))
    json.fail("name", "must be letters, digits, \"_\" and \"-\", but is \"" + name + "\"");
  return name;
}

double read_noise(JsonObject json) {
  const double relative = json.number("relative", {0, 10, false, false});
  json.finish();
  return relative;
}

/// Settings as text, as the command line gives them: {"criterion": "error", "quality": 0.2}.
std::map<std::string, std::string> read_settings(JsonObject& json) {
  std::map<std::string, std::string> settings;
  if (!json.has("settings")) return settings;
  const nlohmann::json& raw = json.raw("settings");
  if (!raw.is_object()) json.fail("settings", "must be an object of numbers and words");
  for (const auto& [key, value] : raw.items()) {
    if (!value.is_string() && !value.is_number()) json.fail("settings", "\"" + key + "\" must be a number or a word");
    settings[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return settings;
}

}  // namespace

Recipe parse_recipe(const nlohmann::json& document, const std::string& path) {
  constexpr int most = std::numeric_limits<int>::max();
  JsonObject json(document, path, "");
  check_format(json);
  Recipe recipe;
  recipe.path = path;
  recipe.name = read_name(json);
  recipe.summary = json.text("summary");
  json.object("scene");  // an object, at least
  recipe.scene = json.raw("scene");
  recipe.material = json.text("material");
  recipe.noise_relative = read_noise(json.object("noise"));
  recipe.seed = static_cast<std::uint64_t>(json.integer("seed", 0, most));
  recipe.starts = json.integer("starts", 1, 10000);
  recipe.samples = static_cast<std::size_t>(json.integer("samples", 1, 100'000'000));
  recipe.technique = json.text("technique");
  recipe.settings = read_settings(json);
  json.finish();
  return recipe;
}

Recipe load_recipe(const std::string& path) { return parse_recipe(read_json_file(path), path); }

const std::vector<Recipe>& shipped_recipes() {
  static const std::vector<Recipe> recipes = [] {
    std::vector<Recipe> all;
    for (const EmbeddedRecipe& row : embedded)
      all.push_back(parse_recipe(nlohmann::json::parse(row.text), std::string(row.name) + ".json"));
    return all;
  }();
  return recipes;
}

Recipe find_recipe(const std::string& name_or_file) {
  if (std::filesystem::path(name_or_file).extension() == ".json") return load_recipe(name_or_file);
  std::vector<std::string> names;
  for (const Recipe& recipe : shipped_recipes()) {
    if (recipe.name == name_or_file) return recipe;
    names.push_back(recipe.name);
  }
  throw InputError("NAME", "", unknown_choice("recipe", name_or_file, names) + "; or give a file that ends in .json");
}

}  // namespace opaline
