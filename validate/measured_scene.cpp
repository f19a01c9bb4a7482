#include "validate/measured_scene.h"

#include "render/scene/json_object.h"
#include "render/stopwatch.h"
#include "validate/content_hash.h"
#include "validate/shared_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// The scene without the work of making its meshes: each object is a stand-in until `meshes` take its place.
Scene scene_with_meshes(const SceneCase& c, std::vector<Mesh> meshes) {
  json document = c.document;
  for (json& object : document["objects"]) object = {{"shape", "stand_in"}, {"material", object["material"]}};
  const ShapeLibrary library = {{"stand_in", {"", [](JsonObject&) {
                                                Mesh mesh;
                                                mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
                                                mesh.triangles = {{0, 1, 2}};
                                                return mesh;
                                              }}}};
  Scene scene = parse_scene(document, c.path, library);
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const json& object = c.document["objects"][i];
    scene.objects[i].name = object.contains("mesh") ? object["mesh"].get<std::string>() : object.value("shape", "");
    scene.objects[i].mesh = std::move(meshes[i]);
  }
  return scene;
}

/// A name as part of a file's that a shell takes for one word: materials are called "Head & Shoulders Shampoo".
std::string one_word(std::string name) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '+' && c != '.') c = '_';
  return name;
}

SharedSettings shared_settings(const Suite& suite) {
  return {suite.samples, {.area_samples = suite.light_samples, .seed = suite.seed}};
}

double rms(const Image& image, bool is_variance) {
  double sum = 0;
  std::size_t count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c, ++count) {
        const double v = static_cast<double>(image.at(x, y, c));
        sum += is_variance ? v : v * v;
      }
  return std::sqrt(sum / static_cast<double>(count));
}

double largest(const Image& image) {
  return image.data.empty() ? 0.0 : static_cast<double>(*std::max_element(image.data.begin(), image.data.end()));
}

}  // namespace

MeasuredScene::MeasuredScene(const Suite& suite, const SceneCase& c, const ShapeLibrary& shapes,
                             const std::string& folder)
    : suite_(suite), case_(c), folder_(folder) {
  for (const char* name : {"cache", "images", "scenes"}) fs::create_directories(fs::path(folder) / name);
  scene_file = "scenes/" + c.name + "_" + one_word(c.material) + ".json";
  write_text_atomically(folder + "/" + scene_file, c.document.dump(2) + "\n");
  const SharedSettings settings = shared_settings(suite);
  const json key = {{"program", program_hash()},
                    {"scene", c.hash},
                    {"samples", settings.samples},
                    {"light_samples", suite.light_samples},
                    {"seed", suite.seed}};
  const std::string file = folder + "/cache/scene-" + ContentHash().add(key.dump()).hex() + ".bin";
  if (std::optional<SceneParts> parts = load_scene_parts(file)) {
    scene = scene_with_meshes(c, std::move(parts->meshes));
    load_seconds = parts->load_seconds;
    shared = std::make_unique<SharedScene>(scene, settings, std::move(parts->shared));
    return;
  }
  Stopwatch watch;
  scene = parse_scene(c.document, c.path, shapes);
  load_seconds = watch.lap();
  shared = std::make_unique<SharedScene>(scene, settings);
  SceneParts parts{{}, *shared, load_seconds};
  for (const Object& object : scene.objects) parts.meshes.push_back(object.mesh);
  save_scene_parts(file, parts);
}

ReferenceImage MeasuredScene::make(const std::string& name, const SettingValues& settings, const char* error_layer) {
  const Technique& technique = find_technique(name);
  // Truth must not share its random numbers with what is measured against it.
  std::uint64_t& seed = shared->settings.irradiance.seed;
  const std::uint64_t measured_seed = seed;
  if (technique.statistical) seed += 1'000'003;
  Stopwatch watch;
  const auto prepared = technique.prepare(*shared, Settings(technique.settings, settings));
  const Frame frame = prepared->render(shared->view);
  seed = measured_seed;
  ReferenceImage made;
  made.image = shade(scene, shared->view, frame);
  const std::map<std::string, Image> layers = shade_layers(scene, shared->view, frame);
  made.seconds = watch.lap();
  made_seconds_ += made.seconds;
  const auto layer = layers.find(error_layer);
  if (layer == layers.end()) return made;
  const bool is_variance = std::string(error_layer) == "variance";
  const double size = rms(made.image, false);
  made.relative_error = size > 0 ? rms(layer->second, is_variance) / size : 0;
  made.max_error = is_variance ? std::sqrt(largest(layer->second)) : largest(layer->second);
  made.error_file = error_layer;
  write_exr(folder_ + "/images/" + error_layer + ".part.exr", layer->second);
  return made;
}

ReferenceImage MeasuredScene::find_or_make(const std::string& name, const SettingValues& settings,
                                           const char* error_layer) {
  const json key = {{"program", program_hash()}, {"scene", case_.hash},
                    {"samples", suite_.samples}, {"light_samples", suite_.light_samples},
                    {"seed", suite_.seed},       {"technique", name},
                    {"settings", settings}};
  const std::string hash = ContentHash().add(key.dump()).hex(), stem = "images/" + name + "-" + hash;
  const std::string facts = folder_ + "/cache/" + name + "-" + hash + ".json";
  std::error_code ignored;
  if (fs::exists(facts, ignored) && fs::exists(folder_ + "/" + stem + ".exr", ignored)) {
    const json known = read_json_file(facts);
    ReferenceImage found{read_image(folder_ + "/" + stem + ".exr"),
                         stem + ".exr",
                         known.at("error_file"),
                         known.at("relative_error"),
                         known.at("max_error"),
                         known.at("seconds"),
                         {}};
    return found;
  }
  ReferenceImage made = make(name, settings, error_layer);
  made.file = stem + ".exr";
  write_exr(folder_ + "/" + made.file, made.image);
  if (!made.error_file.empty()) {
    fs::rename(folder_ + "/images/" + made.error_file + ".part.exr", folder_ + "/" + stem + "-" + error_layer + ".exr");
    made.error_file = stem + "-" + error_layer + ".exr";
  }
  const json known = {{"error_file", made.error_file},
                      {"relative_error", made.relative_error},
                      {"max_error", made.max_error},
                      {"seconds", made.seconds}};
  write_text_atomically(facts, known.dump(2) + "\n");
  return made;
}

std::string MeasuredScene::reference_technique() const {
  for (const char* name : {"hierarchical", "single_scatter_exact"})
    if (why_not_applicable(find_technique(name), scene).empty()) return name;
  return {};
}

const ReferenceImage& MeasuredScene::reference(const std::string& profile) {
  if (const std::string name = reference_technique(); name != "hierarchical") {
    const auto known = references_.find(name);
    if (known != references_.end()) return known->second;
    ReferenceImage& made = references_[name] = find_or_make(name, suite_.layered_reference, "error");
    made.settings = suite_.layered_reference;
    return made;
  }
  SettingValues settings = suite_.reference;
  if (!profile.empty()) settings["profile"] = profile;
  // Named even where it is the default, so that both ways of asking find the same image.
  settings["profile"] = Settings(find_technique("hierarchical").settings, settings).word("profile");
  const auto known = references_.find(settings["profile"]);
  if (known != references_.end()) return known->second;
  ReferenceImage& made = references_[settings["profile"]] = find_or_make("hierarchical", settings, "bound");
  made.settings = settings;
  return made;
}

const ReferenceImage* MeasuredScene::truth() {
  if (!suite_.truth) return nullptr;
  const std::vector<std::string>& scenes = suite_.truth->scenes;
  if (!scenes.empty() && std::find(scenes.begin(), scenes.end(), case_.name) == scenes.end()) return nullptr;
  if (!why_not_applicable(find_technique("path_traced"), scene).empty()) return nullptr;
  if (!truth_) truth_ = find_or_make("path_traced", suite_.truth->settings, "variance");
  return &*truth_;
}

}  // namespace opaline
