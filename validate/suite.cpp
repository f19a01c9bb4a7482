#include "validate/suite.h"

#include "datasets_synthetic/layered/layered_datasets.h"
#include "datasets_synthetic/recipe.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

struct EmbeddedSuite {
  const char *name, *text;
};
constexpr EmbeddedSuite embedded[] = {
#include "suites.inc"
};

std::vector<std::string> technique_names() {
  std::vector<std::string> names;
  for (const Technique& technique : techniques()) names.push_back(technique.name);
  return names;
}

std::string checked_name(JsonObject& in) {
  std::string name = in.text("name");
  const auto good = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; };
  if (name.empty() || !std::all_of(name.begin(), name.end(), good))
    in.fail("name", "must be letters, digits, \"_\" and \"-\", but is \"" + name + "\"");
  return name;
}

/// A list of words out of `valid`, each at most once.
std::vector<std::string> words(JsonObject& in, const std::string& key, const std::string& kind,
                               const std::vector<std::string>& valid) {
  const json& raw = in.raw(key);
  if (!raw.is_array()) in.fail(key, "must be an array of words");
  std::vector<std::string> result;
  for (const json& word : raw) {
    if (!word.is_string()) in.fail(key, "must be an array of words");
    const std::string text = word.get<std::string>();
    if (!valid.empty() && std::find(valid.begin(), valid.end(), text) == valid.end())
      in.fail(key, unknown_choice(kind, text, valid));
    if (std::find(result.begin(), result.end(), text) != result.end()) in.fail(key, "\"" + text + "\" stands twice");
    result.push_back(text);
  }
  return result;
}

std::string setting_text(JsonObject& in, const std::string& key, const json& value) {
  if (!value.is_string() && !value.is_number()) in.fail(key, "settings must be numbers or words");
  return value.is_string() ? value.get<std::string>() : value.dump();
}

/// {"a": 1, "b": [2, 3]} as the settings {a=1, b=2} and {a=1, b=3}.
std::vector<SettingValues> grid(JsonObject& in, const std::string& key, const json& object) {
  if (!object.is_object()) in.fail(key, "must be an array of objects {\"setting\": value or array of values}");
  std::vector<SettingValues> all = {{}};
  for (const auto& [setting, value] : object.items()) {
    const json values = value.is_array() ? value : json::array({value});
    if (values.empty()) in.fail(key, "\"" + setting + "\" must have at least one value");
    std::vector<SettingValues> extended;
    for (const SettingValues& before : all)
      for (const json& v : values) {
        extended.push_back(before);
        extended.back()[setting] = setting_text(in, key, v);
      }
    all = std::move(extended);
  }
  return all;
}

/// Settings must be the technique's own, with valid values.
void check_settings(JsonObject& in, const std::string& key, const std::string& technique, const SettingValues& given) {
  try {
    [[maybe_unused]] const Settings checked(find_technique(technique).settings, given);
  } catch (const InputError& error) {
    in.fail(key, error.what());
  }
}

void read_sweeps(JsonObject in, Suite& suite) {
  for (const std::string& technique : technique_names()) {
    if (!in.has(technique)) continue;
    const json& list = in.raw(technique);
    if (!list.is_array() || list.empty()) in.fail(technique, "must be an array of objects, not empty");
    for (const json& object : list)
      for (SettingValues& settings : grid(in, technique, object)) {
        check_settings(in, technique, technique, settings);
        suite.sweeps[technique].push_back(std::move(settings));
      }
  }
  in.finish();
}

SettingValues read_settings(JsonObject& in, const std::string& key, const std::string& technique) {
  const std::vector<SettingValues> all = grid(in, key, in.raw(key));
  if (all.size() != 1) in.fail(key, "must be one value each");
  check_settings(in, key, technique, all[0]);
  return all[0];
}

std::vector<SuiteMaterial> read_materials(JsonObject& in) {
  if (!in.has("materials")) return {};
  const json& raw = in.raw("materials");
  if (!raw.is_array()) in.fail("materials", "must be an array of library names or objects with a \"name\"");
  std::vector<SuiteMaterial> materials;
  for (const json& m : raw) {
    if (m.is_string()) {
      materials.push_back({m.get<std::string>(), {{"library", m}}});
    } else if (m.is_object() && m.contains("name") && m["name"].is_string()) {
      materials.push_back({m["name"].get<std::string>(), m});
      materials.back().value.erase("name");
    } else {
      in.fail("materials", "must be an array of library names or objects with a \"name\"");
    }
    const auto same = [&](const SuiteMaterial& other) { return other.name == materials.back().name; };
    if (std::any_of(materials.begin(), materials.end() - 1, same))
      in.fail("materials", "two materials are called \"" + materials.back().name + "\"");
  }
  return materials;
}

/// A built-in dataset's scene, or that of a recipe's file.
void read_recipe(JsonObject& in, SuiteScene& scene) {
  const std::string name = in.text("recipe");
  std::vector<std::string> names;
  for (const Recipe& recipe : shipped_recipes()) names.push_back(recipe.name);
  for (const LayeredDataset& dataset : layered_datasets()) names.push_back(dataset.name);
  if (const LayeredDataset* dataset = find_layered_dataset(name)) {
    scene.dataset = name;
    scene.document = dataset->scene();
  } else if (fs::path(name).extension() == ".json" || std::find(names.begin(), names.end(), name) != names.end()) {
    scene.document = find_recipe(name).scene;
  } else {
    in.fail("recipe", unknown_choice("dataset", name, names));
  }
}

/// The document from one of "scene" (inline, or a file beside the suite) and "recipe".
void read_document(JsonObject& in, const std::string& suite_path, SuiteScene& scene) {
  if (in.has("scene") == in.has("recipe"))
    throw InputError(in.file(), in.pointer(), "needs exactly one of \"scene\" and \"recipe\"");
  scene.path = suite_path;
  if (in.has("recipe")) {
    read_recipe(in, scene);
  } else if (in.raw("scene").is_string()) {
    scene.path = (fs::path(suite_path).parent_path() / in.text("scene")).string();
    scene.document = read_json_file(scene.path);
  } else {
    in.object("scene");  // an object
    scene.document = in.raw("scene");
  }
  if (in.has("film")) scene.document["film"] = in.raw("film");
}

SuiteScene read_scene(JsonObject in, const std::string& suite_path, const std::vector<SuiteMaterial>& materials) {
  SuiteScene scene;
  scene.name = checked_name(in);
  read_document(in, suite_path, scene);
  scene.materials = in.has("materials") ? read_materials(in) : materials;
  in.finish();
  return scene;
}

void read_scenes(JsonObject& in, Suite& suite) {
  const std::vector<SuiteMaterial> materials = read_materials(in);
  for (JsonObject& object : in.objects("scenes")) {
    SuiteScene scene = read_scene(object, suite.path, materials);
    for (const SuiteScene& other : suite.scenes)
      if (other.name == scene.name) object.fail("name", "two scenes are called \"" + scene.name + "\"");
    suite.scenes.push_back(std::move(scene));
  }
  if (suite.scenes.empty()) in.fail("scenes", "must have at least one scene");
}

void read_truth(JsonObject in, Suite& suite) {
  SuiteTruth& truth = suite.truth.emplace();
  std::vector<std::string> names;
  for (const SuiteScene& scene : suite.scenes) names.push_back(scene.name);
  if (in.has("scenes")) truth.scenes = words(in, "scenes", "scene", names);
  truth.settings["paths"] = std::to_string(in.integer("paths", 2, 1'000'000));
  in.finish();
}

void read_techniques(JsonObject& in, Suite& suite) {
  if (!in.has("techniques")) return;
  if (in.raw("techniques").is_string())
    in.choice("techniques", {"all"});
  else
    suite.techniques = words(in, "techniques", "technique", technique_names());
}

void read_measuring(JsonObject& in, Suite& suite) {
  suite.samples = static_cast<std::size_t>(in.integer_or("samples", 1, 100'000'000, 20000));
  suite.light_samples = in.integer_or("light_samples", 1, 1'000'000, suite.light_samples);
  suite.seed = static_cast<std::uint64_t>(in.integer_or("seed", 0, 2147483647, 1));
  suite.runs = in.integer_or("runs", 1, 1000, suite.runs);
  suite.max_seconds = in.number_or("max_seconds", Range::positive(), suite.max_seconds);
  suite.images = in.boolean_or("images", suite.images);
  if (in.has("reference")) suite.reference = read_settings(in, "reference", "hierarchical");
  if (in.has("layered_reference"))
    suite.layered_reference = read_settings(in, "layered_reference", "single_scatter_exact");
}

}  // namespace

Suite parse_suite(const json& document, const std::string& path) {
  JsonObject in(document, path, "");
  in.choice("format", {"opaline-suite"});
  in.integer("version", 1, 1);
  Suite suite;
  suite.path = path;
  suite.name = checked_name(in);
  suite.summary = in.text_or("summary", "");
  read_scenes(in, suite);
  read_techniques(in, suite);
  if (in.has("backends")) suite.backends = words(in, "backends", "backend", {"cpu", "gpu"});
  if (in.has("sweeps")) read_sweeps(in.object("sweeps"), suite);
  if (in.has("edits")) suite.edits = words(in, "edits", "edit", {"camera", "light", "material", "geometry"});
  read_measuring(in, suite);
  if (in.has("truth")) read_truth(in.object("truth"), suite);
  in.finish();
  return suite;
}

std::vector<std::string> shipped_suite_names() {
  std::vector<std::string> names;
  for (const EmbeddedSuite& row : embedded) names.emplace_back(row.name);
  return names;
}

Suite find_suite(const std::string& name_or_file) {
  if (fs::path(name_or_file).extension() == ".json") return parse_suite(read_json_file(name_or_file), name_or_file);
  for (const EmbeddedSuite& row : embedded)
    if (name_or_file == row.name) return parse_suite(json::parse(row.text), name_or_file + ".json");
  throw InputError(
      "SUITE", "",
      unknown_choice("suite", name_or_file, shipped_suite_names()) + "; or give a file that ends in .json");
}

}  // namespace opaline
