#include "model/materials/library.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/scene_parts.h"

#include <cmath>

namespace opaline {
namespace {

Material from_library(const MaterialRow& row) {
  Material material;
  material.name = row.name;
  for (int c = 0; c < 3; ++c) {
    material.sigma_a[c] = row.sigma_a[static_cast<std::size_t>(c)];
    material.sigma_s_prime[c] = row.sigma_s_prime[static_cast<std::size_t>(c)];
  }
  material.eta = row.eta;
  return material;
}

/// A library row may lack a number (NaN), and a medium must do something to light.
void check_material(const Material& material, const std::string& file, const std::string& place) {
  for (int c = 0; c < 3; ++c) {
    const double sum = material.sigma_a[c] + material.sigma_s_prime[c];
    if (std::isfinite(sum) && sum > 0) continue;
    throw InputError(file, place,
                     "sigma_a_per_mm + sigma_s_prime_per_mm must be > 0 and finite in each channel, but " +
                         std::string("is ") + std::to_string(sum) + " in channel " + std::to_string(c));
  }
  if (!(material.eta > 0)) throw InputError(file, place, "the library has no eta for this material; give \"eta\"");
}

Material library_base(JsonObject& json) {
  const std::string name = json.text("library");
  const MaterialRow* row = find_material(name);
  if (row == nullptr) json.fail("library", unknown_choice("library material", name, material_names()));
  return from_library(*row);
}

Material read_material(const std::string& name, JsonObject& json) {
  const bool has_base = json.has("library");
  Material material = has_base ? library_base(json) : Material{};
  material.name = name;
  const auto wanted = [&](const char* key) { return json.has(key) || !has_base; };
  if (wanted("sigma_a_per_mm")) material.sigma_a = json.rgb("sigma_a_per_mm", Range::non_negative());
  if (wanted("sigma_s_prime_per_mm")) material.sigma_s_prime = json.rgb("sigma_s_prime_per_mm", Range::non_negative());
  if (wanted("eta")) material.eta = json.number("eta", Range::positive());
  material.g = json.number_or("g", {-1, 1, true, true}, 0);
  json.finish();
  check_material(material, json.file(), json.pointer());
  return material;
}

std::vector<std::string> names_of(const std::vector<Material>& materials) {
  std::vector<std::string> names;
  for (const Material& material : materials) names.push_back(material.name);
  return names;
}

int index_of(const std::vector<Material>& materials, const std::string& name) {
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (materials[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

[[noreturn]] void throw_unknown(const JsonObject& object, const std::string& name,
                                const std::vector<Material>& materials) {
  std::vector<std::string> all = names_of(materials);
  const std::string own = join_names(all);
  for (const std::string& known : material_names()) all.push_back(known);
  const std::string nearest = nearest_choice(name, all);
  const std::string question = nearest.empty() ? "" : " did you mean \"" + nearest + "\"?";
  object.fail("material", "unknown material \"" + name + "\";" + question + " materials of the scene: " + own +
                              "; of the library: " + join_names(material_names()));
}

}  // namespace

std::vector<Material> read_materials(JsonObject& root) {
  std::vector<Material> materials;
  if (!root.has("materials")) return materials;
  for (auto& [name, json] : root.members("materials")) materials.push_back(read_material(name, json));
  return materials;
}

int find_or_add_material(JsonObject& object, std::vector<Material>& materials) {
  const std::string name = object.text("material");
  if (const int own = index_of(materials, name); own >= 0) return own;
  const MaterialRow* row = find_material(name);
  if (row == nullptr) throw_unknown(object, name, materials);
  if (const int added = index_of(materials, row->name); added >= 0) return added;
  materials.push_back(from_library(*row));
  check_material(materials.back(), object.file(), object.pointer() + "/material");
  return static_cast<int>(materials.size()) - 1;
}

}  // namespace opaline
