#include "model/materials/library.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/scene_parts.h"

#include <algorithm>
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

using Map = std::shared_ptr<const MaterialMap>;

Map read_map(JsonObject json, const SceneContext& context) {
  auto map = std::make_shared<MaterialMap>();
  map->texture = read_surface_texture(json, context);
  if (json.has("scale")) map->scale = json.rgb("scale", Range::non_negative());
  json.finish();
  const Image& image = *map->texture.image;
  const int channels = image.channel_count();
  const bool coloured = channels >= 3 && image.channel("R") == 0 && image.channel("G") == 1 && image.channel("B") == 2;
  if (channels != 1 && !coloured) json.fail("image", "needs the channels R, G and B, or just one for all three");
  if (glm::any(glm::lessThan(map->smallest(), Rgb(0)))) json.fail("image", "has values below 0");
  return map;
}

/// A coefficient: three numbers, one, or a map.
void read_coefficient(JsonObject& json, const std::string& key, const SceneContext& context, Rgb& value, Map& map) {
  if (json.raw(key).is_object()) {
    map = read_map(json.object(key), context);
    value = map->mean();
  } else {
    map = nullptr;
    value = json.rgb(key, Range::non_negative());
  }
}

/// Every place of a textured surface is a medium.
void check_maps(const Material& m, const JsonObject& json) {
  if (!m.textured()) return;
  const Rgb least = (m.sigma_a_map ? m.sigma_a_map->smallest() : m.sigma_a) +
                    (m.sigma_s_prime_map ? m.sigma_s_prime_map->smallest() : m.sigma_s_prime);
  if (std::min({least.r, least.g, least.b}) > 0) return;
  throw InputError(json.file(), json.pointer(),
                   "the smallest sigma_a_per_mm and the smallest sigma_s_prime_per_mm of its images must not both be 0 "
                   "in a channel");
}

/// Layers stand in place of the coefficients.
Material read_layered_material(const std::string& name, JsonObject& json, const SceneContext& context) {
  for (const char* other : {"library", "sigma_a_per_mm", "sigma_s_prime_per_mm", "g"})
    if (json.has(other)) json.fail(other, "does not go with \"layers\", which have coefficients of their own");
  Material material;
  material.name = name;
  material.eta = json.number_or("eta", Range::positive(), 1);
  material.layers = read_layers(json.object("layers"), context);
  json.finish();
  const SubsurfaceLayer& first = material.layers->layers.front();
  material.sigma_a = first.sigma_t - first.sigma_s;
  material.g = first.g;
  material.sigma_s_prime = (1 - first.g) * first.sigma_s;
  return material;
}

Material read_material(const std::string& name, JsonObject& json, const SceneContext& context) {
  if (json.has("layers")) return read_layered_material(name, json, context);
  const bool has_base = json.has("library");
  Material material = has_base ? library_base(json) : Material{};
  material.name = name;
  const auto wanted = [&](const char* key) { return json.has(key) || !has_base; };
  if (wanted("sigma_a_per_mm"))
    read_coefficient(json, "sigma_a_per_mm", context, material.sigma_a, material.sigma_a_map);
  if (wanted("sigma_s_prime_per_mm"))
    read_coefficient(json, "sigma_s_prime_per_mm", context, material.sigma_s_prime, material.sigma_s_prime_map);
  if (wanted("eta")) material.eta = json.number("eta", Range::positive());
  material.g = json.number_or("g", {-1, 1, true, true}, 0);
  json.finish();
  check_material(material, json.file(), json.pointer());
  check_maps(material, json);
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

Material Material::at(const glm::vec2& uv) const {
  Material here = *this;
  if (sigma_a_map) here.sigma_a = sigma_a_map->at(uv);
  if (sigma_s_prime_map) here.sigma_s_prime = sigma_s_prime_map->at(uv);
  here.sigma_a_map = here.sigma_s_prime_map = nullptr;
  return here;
}

SurfaceTexture read_surface_texture(JsonObject& json, const SceneContext& context) {
  using Wrap = SurfaceTexture::Wrap;
  SurfaceTexture texture;
  texture.path = context.resolve(json.text("image"));
  const std::string wrap = json.choice_or("wrap", {"repeat", "clamp", "mirror"}, "repeat");
  texture.wrap = wrap == "clamp" ? Wrap::clamp : wrap == "mirror" ? Wrap::mirror : Wrap::repeat;
  const bool nearest = json.choice_or("filter", {"bilinear", "nearest"}, "bilinear") == "nearest";
  texture.filter = nearest ? SurfaceTexture::Filter::nearest : SurfaceTexture::Filter::bilinear;
  texture.image = load_for_key(json, "image", [&] { return std::make_shared<const Image>(read_image(texture.path)); });
  const auto bad =
      std::count_if(texture.image->data.begin(), texture.image->data.end(), [](float v) { return !std::isfinite(v); });
  if (bad > 0) json.fail("image", std::to_string(bad) + " of its values are NaN or infinite");
  return texture;
}

std::vector<Material> read_materials(JsonObject& root, const SceneContext& context) {
  std::vector<Material> materials;
  if (!root.has("materials")) return materials;
  for (auto& [name, json] : root.members("materials")) materials.push_back(read_material(name, json, context));
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
