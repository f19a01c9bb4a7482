#include "render/scene/scene.h"

#include "render/input_error.h"
#include "render/scene/scene_parts.h"

#include <cmath>

namespace opaline {
namespace {

constexpr int max_film_size = 16384;

void check_format(JsonObject& root) {
  const std::string format = root.text("format");
  if (format != "opaline-scene") root.fail("format", "must be \"opaline-scene\", but is \"" + format + "\"");
  root.integer("version", 1, 1);
}

Film read_film(JsonObject json) {
  Film film;
  film.width = json.integer("width", 1, max_film_size);
  film.height = json.integer("height", 1, max_film_size);
  json.finish();
  return film;
}

void read_lights(JsonObject& root, const SceneContext& context, Scene& scene) {
  for (JsonObject& light : root.objects("lights")) scene.lights.push_back(read_light(light, context));
  if (scene.lights.empty()) root.fail("lights", "needs at least one light, or every image is black");
}

void read_objects(JsonObject& root, const SceneContext& context, Scene& scene) {
  for (JsonObject& object : root.objects("objects")) {
    scene.objects.push_back(read_object(object, context, scene.materials, scene.dropped_triangles));
  }
  if (scene.objects.empty()) root.fail("objects", "needs at least one object");
}

/// So that a misspelt optional key is reported before anything large is loaded.
void check_keys(JsonObject& root) {
  for (const char* key : {"format", "version", "mm_per_unit", "film", "camera", "lights", "materials", "objects"}) {
    root.has(key);
  }
  root.finish();
}

}  // namespace

Viewpoint read_viewpoint(JsonObject& json, double mm_per_unit) {
  Viewpoint view;
  view.position = json.vec3("position") * mm_per_unit;
  view.look_at = json.vec3("look_at") * mm_per_unit;
  view.up = json.vec3_or("up", Range::any(), {0, 1, 0});
  const glm::dvec3 direction = view.look_at - view.position;
  const double distance = glm::length(direction), up_length = glm::length(view.up);
  if (!(distance > 0)) json.fail("look_at", "must differ from \"position\"");
  if (!(up_length > 0)) json.fail("up", "must not be the zero vector");
  const double sine = glm::length(glm::cross(direction / distance, view.up / up_length));
  if (!(sine > 1e-6)) json.fail("up", "must not be parallel to the view direction (look_at - position)");
  return view;
}

Camera read_camera(JsonObject json, const SceneContext& context) {
  Camera camera;
  const bool perspective = json.choice("type", {"perspective", "orthographic"}) == "perspective";
  camera.type = perspective ? Camera::Type::perspective : Camera::Type::orthographic;
  const Viewpoint view = read_viewpoint(json, context.mm_per_unit);
  camera.position = view.position;
  camera.look_at = view.look_at;
  camera.up = view.up;
  if (perspective) {
    camera.fov_y_deg = json.number("fov_y_deg", {0, 180, true, true});
  } else {
    camera.height = json.number("height", Range::positive()) * context.mm_per_unit;
  }
  json.finish();
  return camera;
}

Scene parse_scene(const nlohmann::json& document, const std::string& path, const ShapeLibrary& shapes) {
  JsonObject root(document, path, "");
  check_format(root);
  check_keys(root);
  SceneContext context{std::filesystem::path(path).parent_path(), 1, shapes};
  context.mm_per_unit = root.number("mm_per_unit", Range::positive());
  Scene scene;
  scene.path = path;
  scene.film = read_film(root.object("film"));
  scene.camera = read_camera(root.object("camera"), context);
  scene.materials = read_materials(root, context);
  read_lights(root, context, scene);
  read_objects(root, context, scene);
  return scene;
}

Scene load_scene(const std::string& path, const ShapeLibrary& shapes) {
  return parse_scene(read_json_file(path), path, shapes);
}

}  // namespace opaline
