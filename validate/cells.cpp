#include "validate/cells.h"

#include "render/choices.h"
#include "render/file.h"
#include "render/input_error.h"
#include "validate/content_hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

bool chosen(const std::vector<std::string>& choice, const std::string& name) {
  return choice.empty() || std::find(choice.begin(), choice.end(), name) != choice.end();
}

/// Makes file names absolute and takes in what they hold. A missing file is found when the scene is loaded.
void resolve_files(json& value, const fs::path& folder, ContentHash& hash) {
  if (value.is_array())
    for (json& element : value) resolve_files(element, folder, hash);
  if (!value.is_object()) return;
  for (const char* key : {"mesh", "image"}) {
    const auto it = value.find(key);
    if (it == value.end() || !it->is_string()) continue;
    const fs::path file = fs::absolute(folder / it->get<std::string>()).lexically_normal();
    *it = file.string();
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) hash.add(read_file(file.string()));
  }
  for (auto& [key, member] : value.items()) resolve_files(member, folder, hash);
}

/// The names of the scene's own materials: "m1" or "m1+m2".
std::string own_materials(const json& document) {
  std::string names;
  if (document.contains("materials") && document["materials"].is_object())
    for (const auto& [name, value] : document["materials"].items()) {
      const bool library = value.is_object() && value.contains("library") && value["library"].is_string();
      names += (names.empty() ? "" : "+") + (library ? value["library"].get<std::string>() : name);
    }
  return names.empty() ? "none" : names;
}

void set_material(json& document, const SuiteMaterial& material) {
  document["materials"] = {{material.name, material.value}};
  if (!document.contains("objects") || !document["objects"].is_array()) return;
  for (json& object : document["objects"])
    if (object.is_object()) object["material"] = material.name;
}

SceneCase make_case(const SuiteScene& scene, const SuiteMaterial* material) {
  SceneCase made{scene.name, material ? material->name : own_materials(scene.document), scene.path, scene.document, {}};
  if (material) set_material(made.document, *material);
  ContentHash hash;
  resolve_files(made.document, fs::path(scene.path).parent_path(), hash);
  made.hash = hash.add(made.document.dump()).hex();
  return made;
}

/// The settings with every default, so that a changed default is another cell.
std::string full_settings(const Technique& technique, const SettingValues& settings) {
  return json(Settings(technique.settings, settings).values()).dump();
}

std::string hash_of(const Cell& cell, const Suite& suite, const std::vector<SceneCase>& cases,
                    const CellChoice& choice) {
  const SceneCase& scene = cases[cell.scene];
  const bool truth = suite.truth && chosen(suite.truth->scenes, scene.name);
  const json parts = {{"program", program_hash()},
                      {"scene", scene.hash},
                      {"technique", cell.name},
                      {"backend", cell.backend},
                      {"settings", cell.technique ? full_settings(*cell.technique, cell.settings) : cell.command},
                      {"gl", cell.backend == "gpu" ? choice.gl : ""},
                      {"threads", choice.threads},
                      {"edits", suite.edits},
                      {"shared", {suite.samples, suite.light_samples, suite.seed}},
                      {"times", {suite.runs, suite.max_seconds}},
                      {"reference", suite.reference},
                      {"layered_reference", suite.layered_reference},
                      {"truth", truth ? json(suite.truth->settings) : json()},
                      {"images", suite.images}};
  return ContentHash().add(parts.dump()).hex();
}

void check_choice(const std::string& option, const std::string& kind, const std::vector<std::string>& given,
                  const std::vector<std::string>& valid) {
  for (const std::string& name : given)
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      throw InputError(option, "", unknown_choice(kind, name, valid));
}

/// The registered techniques of the suite that are also chosen.
std::vector<const Technique*> chosen_techniques(const Suite& suite, const CellChoice& choice) {
  std::vector<const Technique*> result;
  std::vector<std::string> names;
  for (const Technique& t : techniques()) {
    if (!chosen(suite.techniques, t.name)) continue;
    names.push_back(t.name);
    if (chosen(choice.techniques, t.name)) result.push_back(&t);
  }
  for (const ExternalTechnique& external : choice.externals) {
    if (std::find(names.begin(), names.end(), external.name) != names.end())
      throw InputError("--external", "", fmt::format("\"{}\" is a technique already", external.name));
    names.push_back(external.name);
  }
  check_choice("--technique", "technique", choice.techniques, names);
  return result;
}

}  // namespace

ExternalTechnique parse_external(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError("--external", "", fmt::format("\"{}\" is not NAME=COMMAND", text));
  ExternalTechnique external{text.substr(0, equals), text.substr(equals + 1)};
  for (const char* place : {"{scene}", "{out}"})
    if (external.command.find(place) == std::string::npos)
      throw InputError("--external", "", fmt::format("the command \"{}\" lacks {}", external.command, place));
  return external;
}

std::vector<SceneCase> scene_cases(const Suite& suite, const CellChoice& choice) {
  std::vector<std::string> names;
  std::vector<SceneCase> cases;
  for (const SuiteScene& scene : suite.scenes) {
    names.push_back(scene.name);
    if (!chosen(choice.scenes, scene.name)) continue;
    if (scene.materials.empty()) cases.push_back(make_case(scene, nullptr));
    for (const SuiteMaterial& material : scene.materials) cases.push_back(make_case(scene, &material));
  }
  check_choice("--scene", "scene", choice.scenes, names);
  return cases;
}

std::vector<Cell> enumerate_cells(const Suite& suite, const std::vector<SceneCase>& cases, const CellChoice& choice) {
  check_choice("--backend", "backend", choice.backends, suite.backends);
  std::vector<Cell> cells;
  const auto add = [&](Cell cell) {
    cell.hash = hash_of(cell, suite, cases, choice);
    cells.push_back(std::move(cell));
  };
  const std::vector<const Technique*> used = chosen_techniques(suite, choice);
  for (std::size_t s = 0; s < cases.size(); ++s) {
    for (const Technique* technique : used) {
      const auto sweep = suite.sweeps.find(technique->name);
      const std::vector<SettingValues> one = {{}};
      for (const std::string& backend : suite.backends)
        if (chosen(choice.backends, backend))
          for (const SettingValues& settings : sweep == suite.sweeps.end() ? one : sweep->second)
            add({s, technique, technique->name, backend, settings, "", ""});
    }
    for (const ExternalTechnique& external : choice.externals)
      if (chosen(choice.techniques, external.name))
        add({s, nullptr, external.name, "external", {}, external.command, ""});
  }
  return cells;
}

}  // namespace opaline
