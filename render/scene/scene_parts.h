// The parts of a scene file, one reader each. Internal to render/scene.
#pragma once

#include "render/input_error.h"
#include "render/scene/json_object.h"
#include "render/scene/scene.h"

#include <filesystem>

namespace opaline {

/// What every part needs to know of its document.
struct SceneContext {
  std::filesystem::path folder;  ///< relative paths start here
  double mm_per_unit = 1;
  const ShapeLibrary& shapes;

  std::string resolve(const std::string& relative) const { return (folder / relative).string(); }
};

/// The "layers" of a material.
std::shared_ptr<const LayeredMedium> read_layers(JsonObject json, const SceneContext& context);

Camera read_camera(JsonObject json, const SceneContext& context);
Light read_light(JsonObject json, const SceneContext& context);

/// Materials of the "materials" key, in the order of their names.
std::vector<Material> read_materials(JsonObject& root, const SceneContext& context);

/// The texture that an object of the document describes: "image", "wrap", "filter". Checks that its values are finite.
SurfaceTexture read_surface_texture(JsonObject& json, const SceneContext& context);

/// Index of the material the object names; a library material is appended on first use.
int find_or_add_material(JsonObject& object, std::vector<Material>& materials);

/// One object, mesh in mm; adds to `dropped` the triangles removed on request.
Object read_object(JsonObject json, const SceneContext& context, std::vector<Material>& materials,
                   std::size_t& dropped);

/// Position, look_at and up of a camera or projector [mm], checked to span a frame.
struct Viewpoint {
  glm::dvec3 position, look_at, up;
};
Viewpoint read_viewpoint(JsonObject& json, double mm_per_unit);

/// Runs `load`, whose errors name another file, and says which key of the scene asked for it.
template <typename Load>
auto load_for_key(const JsonObject& json, const std::string& key, Load load) -> decltype(load()) {
  try {
    return load();
  } catch (const InputError& error) {
    json.fail(key, error.what());
  }
}

}  // namespace opaline
