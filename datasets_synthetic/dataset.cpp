#include "datasets_synthetic/dataset.h"

#include "model/conventions.h"
#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"
#include "render/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;

/// A well-mixed 64-bit number per counter (the finaliser of splitmix64: Steele, Lea, Flood 2014).
std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}

/// In (0, 1), never an end.
double uniform(std::uint64_t bits) { return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53; }

/// Standard normal deviate number `counter` of the stream `seed` (Box & Muller 1958).
double normal_deviate(std::uint64_t seed, std::uint64_t counter) {
  const std::uint64_t stream = mix(seed);
  const double u = uniform(mix(stream ^ (2 * counter))), v = uniform(mix(stream ^ (2 * counter + 1)));
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * pi * v);
}

/// Paths in a scene start at the scene's folder; in the dataset's they must not.
void make_paths_absolute(nlohmann::json& scene, const std::string& path) {
  const fs::path folder = fs::absolute(path).parent_path();
  const auto anchor = [&](nlohmann::json& list, const char* key) {
    for (nlohmann::json& item : list)
      if (item.is_object() && item.contains(key))
        item[key] = (folder / item[key].get<std::string>()).lexically_normal().string();
  };
  anchor(scene["objects"], "mesh");
  anchor(scene["lights"], "image");
  if (!scene.contains("materials")) return;
  for (auto& [name, material] : scene["materials"].items()) anchor(material, "image");
}

/// Index of the recipe's material among the scene's own, where some object must have it.
int true_material(const Recipe& recipe, const Scene& scene) {
  std::vector<std::string> own;
  if (recipe.scene.contains("materials"))
    for (const auto& [name, value] : recipe.scene["materials"].items()) own.push_back(name);
  if (std::find(own.begin(), own.end(), recipe.material) == own.end())
    throw InputError(recipe.path, "/material", unknown_choice("material of the scene", recipe.material, own));
  for (const Object& object : scene.objects)
    if (scene.materials[static_cast<std::size_t>(object.material)].name == recipe.material) return object.material;
  throw InputError(recipe.path, "/material", "no object of the scene is made of \"" + recipe.material + "\"");
}

bool shows_something(const Image& image) {
  for (std::size_t p = 0; p < image.pixel_count(); ++p)
    if (image.data[p * 4 + 3] > 0) return true;
  return false;
}

nlohmann::json to_json(const Rgb& v) { return {v.r, v.g, v.b}; }

/// The profile a recipe is rendered with; path_traced has none.
std::string profile_of(const Recipe& recipe) {
  const auto chosen = recipe.settings.find("profile");
  if (chosen != recipe.settings.end()) return chosen->second;
  for (const SettingSpec& spec : find_technique(recipe.technique).settings)
    if (spec.key == "profile") return spec.fallback;
  return "";
}

nlohmann::json truth_of(const Recipe& recipe, const Material& material, const std::array<double, 3>& noise_sd) {
  return {{"format", "opaline-truth"},
          {"version", 1},
          {"recipe", recipe.name},
          {"material", recipe.material},
          {"parameters",
           {{"sigma_a_per_mm", to_json(material.sigma_a)},
            {"sigma_s_prime_per_mm", to_json(material.sigma_s_prime)},
            {"eta", material.eta}}},
          {"technique", recipe.technique},
          {"profile", profile_of(recipe)},
          {"noise_sd", noise_sd},
          {"noise_relative", recipe.noise_relative},
          {"seed", recipe.seed},
          {"starts", recipe.starts}};
}

/// The renderer's own variance, if it has one, and the noise added since, as the layer "variance" of the target.
void add_variance_layer(const std::map<std::string, Image>& layers, const std::array<double, 3>& sd, Image& target) {
  const auto layer = layers.find("variance");
  if (layer == layers.end()) return;
  Image variance = layer->second;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t i = c; i < variance.data.size(); i += variance.channels.size())
      variance.data[i] += static_cast<float>(sd[c] * sd[c]);
  target = with_layers(target, {{"variance", variance}});
}

RenderOptions render_options(const Recipe& recipe) {
  RenderOptions options;
  options.technique = recipe.technique;
  options.settings = recipe.settings;
  options.shared.samples = recipe.samples;
  options.shared.irradiance.seed = recipe.seed;
  return options;
}

void make_folder(const std::string& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!fs::is_directory(folder)) throw InputError(folder, "", "the folder cannot be made: " + error.message());
}

/// Before the work: a folder that is a file will not become one.
void check_folder(const std::string& folder) {
  std::error_code ignored;
  if (folder.empty()) throw InputError("--out", "", "name the folder to write");
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored))
    throw InputError(folder, "", "is a file, not a folder to write into");
}

}  // namespace

nlohmann::json neutral_start() {
  return {{"sigma_a_per_mm", {0.05, 0.05, 0.05}}, {"sigma_s_prime_per_mm", {1.0, 1.0, 1.0}}, {"eta", 1.35}};
}

std::array<double, 3> add_noise(Image& image, double relative, std::uint64_t seed) {
  const int alpha = image.channel("A");
  const std::array<int, 3> rgb = {image.channel("R"), image.channel("G"), image.channel("B")};
  std::vector<std::size_t> object;
  for (std::size_t p = 0; p < image.pixel_count(); ++p)
    if (image.data[p * image.channels.size() + static_cast<std::size_t>(alpha)] == 1) object.push_back(p);
  std::array<double, 3> sd{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto value = [&](std::size_t p) -> float& {
      return image.data[p * image.channels.size() + static_cast<std::size_t>(rgb[c])];
    };
    double squares = 0;
    for (const std::size_t p : object) squares += static_cast<double>(value(p)) * static_cast<double>(value(p));
    sd[c] = object.empty() ? 0 : relative * std::sqrt(squares / static_cast<double>(object.size()));
    for (const std::size_t p : object)
      value(p) = static_cast<float>(static_cast<double>(value(p)) + sd[c] * normal_deviate(seed, 3 * p + c));
  }
  return sd;
}

Dataset compute_dataset(const Recipe& recipe, const ShapeLibrary& shapes, const StageObserver& observer) {
  const RenderOptions options = render_options(recipe);
  check_render_options(options);
  const Scene scene = parse_scene(recipe.scene, recipe.path, shapes);
  const int material = true_material(recipe, scene);
  const RenderResult result = render_scene(scene, options, observer);
  if (!shows_something(result.image)) throw InputError(recipe.path, "/scene/camera", "sees no object");
  Dataset dataset;
  dataset.truth_scene = recipe.scene;
  make_paths_absolute(dataset.truth_scene, recipe.path);
  dataset.scene = dataset.truth_scene;
  dataset.scene["materials"][recipe.material] = neutral_start();
  dataset.header = image_header(scene, options, result);
  dataset.clean = dataset.target = result.image;
  const std::array<double, 3> sd = add_noise(dataset.target, recipe.noise_relative, recipe.seed);
  add_variance_layer(result.layers, sd, dataset.target);
  dataset.truth = truth_of(recipe, scene.materials[static_cast<std::size_t>(material)], sd);
  return dataset;
}

void make_dataset(const Recipe& recipe, const std::string& folder, const ShapeLibrary& shapes,
                  const StageObserver& observer) {
  check_folder(folder);
  const Dataset dataset = compute_dataset(recipe, shapes, observer);
  make_folder(folder);
  const auto file = [&](const char* name) { return (fs::path(folder) / name).string(); };
  write_exr(file("clean.exr"), dataset.clean, dataset.header);
  write_exr(file("target.exr"), dataset.target, dataset.header);
  write_png(file("target.png"), dataset.target, auto_exposure(dataset.clean));
  write_text_atomically(file("truth_scene.json"), dataset.truth_scene.dump(2) + "\n");
  write_text_atomically(file("truth.json"), dataset.truth.dump(2) + "\n");
  write_text_atomically(file("scene.json"), dataset.scene.dump(2) + "\n");
}

}  // namespace opaline
