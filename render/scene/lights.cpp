#include "render/input_error.h"
#include "render/scene/scene_parts.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

Light read_directional(JsonObject& json, const SceneContext&) {
  DirectionalLight light;
  const glm::dvec3 direction = json.vec3("direction");
  const double length = glm::length(direction);
  if (!(length > 0) || !std::isfinite(length)) json.fail("direction", "must not be the zero vector");
  light.direction = direction / length;
  light.irradiance = json.rgb("irradiance", Range::non_negative());
  light.angular_radius_deg = json.number_or("angular_radius_deg", {0, 90}, 0);
  return light;
}

Light read_point(JsonObject& json, const SceneContext& context) {
  PointLight light;
  light.position = json.vec3("position") * context.mm_per_unit;
  light.intensity = json.rgb("intensity", Range::non_negative());
  return light;
}

/// Colour needs R, G and B (or one channel for grey), and one bad pixel would spoil the whole scene.
void check_light_image(const Image& image) {
  const bool coloured = image.channel("R") >= 0 && image.channel("G") >= 0 && image.channel("B") >= 0;
  if (!coloured && image.channel_count() != 1) {
    throw InputError("the image", "", "needs the channels R, G and B, or just one for grey");
  }
  const auto bad = std::count_if(image.data.begin(), image.data.end(), [](float v) { return !std::isfinite(v); });
  if (bad > 0) throw InputError("the image", "", std::to_string(bad) + " of its values are NaN or infinite");
}

std::shared_ptr<const Image> read_light_image(JsonObject& json, const SceneContext& context, std::string& path) {
  path = context.resolve(json.text("image"));
  return load_for_key(json, "image", [&] {
    auto image = std::make_shared<const Image>(read_image(path));
    check_light_image(*image);
    return image;
  });
}

Light read_environment(JsonObject& json, const SceneContext& context) {
  EnvironmentLight light;
  if (json.has("scale")) light.scale = json.rgb("scale", Range::non_negative());
  light.image = read_light_image(json, context, light.path);
  return light;
}

Light read_projector(JsonObject& json, const SceneContext& context) {
  ProjectorLight light;
  const Viewpoint view = read_viewpoint(json, context.mm_per_unit);
  light.position = view.position;
  light.look_at = view.look_at;
  light.up = view.up;
  light.intensity = json.rgb("intensity", Range::non_negative());
  const bool has_image = json.has("image"), has_disk = json.has("disk_radius_deg");
  if (has_image == has_disk) {
    throw InputError(json.file(), json.pointer(), "needs exactly one of \"image\" and \"disk_radius_deg\"");
  }
  const Range field{0, 180, true, true};
  light.fov_y_deg = has_image ? json.number("fov_y_deg", field) : json.number_or("fov_y_deg", field, light.fov_y_deg);
  if (has_disk) light.disk_radius_deg = json.number("disk_radius_deg", {0, 90, true, true});
  if (has_image) light.image = read_light_image(json, context, light.path);
  return light;
}

}  // namespace

Light read_light(JsonObject json, const SceneContext& context) {
  using Reader = Light (*)(JsonObject&, const SceneContext&);
  const std::pair<const char*, Reader> readers[] = {{"directional", read_directional},
                                                    {"point", read_point},
                                                    {"environment", read_environment},
                                                    {"projector", read_projector}};
  const std::string type = json.choice("type", {"directional", "point", "environment", "projector"});
  for (const auto& [name, read] : readers) {
    if (type != name) continue;
    Light light = read(json, context);
    json.finish();
    return light;
  }
  json.fail("type", "has no reader");
}

}  // namespace opaline
