// The "layers" of a material (declared in scene_parts.h).
#include "render/scene/scene_parts.h"

#include <algorithm>

namespace opaline {
namespace {

SubsurfaceLayer read_layer(JsonObject json) {
  SubsurfaceLayer layer;
  layer.sigma_s = json.rgb("sigma_s_per_mm", Range::non_negative());
  layer.sigma_t = json.rgb("sigma_t_per_mm", Range::non_negative());
  layer.g = json.number_or("g", {-1, 1, true, true}, 0);
  const bool schlick = json.choice_or("phase", {"schlick", "henyey_greenstein"}, "schlick") == "schlick";
  layer.phase = schlick ? Phase::schlick : Phase::henyey_greenstein;
  json.finish();
  if (glm::any(glm::greaterThan(layer.sigma_s, layer.sigma_t)))
    json.fail("sigma_s_per_mm", "must not exceed sigma_t_per_mm in any channel");
  return layer;
}

SurfaceTexture read_depths(JsonObject json, const SceneContext& context) {
  SurfaceTexture texture = read_surface_texture(json, context);
  json.finish();
  const std::vector<float>& values = texture.image->data;
  if (std::any_of(values.begin(), values.end(), [](float v) { return v < 0; }))
    json.fail("image", "has depths below 0");
  return texture;
}

/// Texture j has the channels of layers 4 j to 4 j + 3.
void check_channels(const LayeredMedium& medium, const JsonObject& json) {
  const std::size_t wanted = (medium.layers.size() + 3) / 4;
  if (medium.depths.size() != wanted)
    json.fail("depth_textures", "must be one texture for every four layers: " + std::to_string(wanted) + " for " +
                                    std::to_string(medium.layers.size()) + " layers");
  for (std::size_t j = 0; j < wanted; ++j) {
    const std::size_t needed = std::min<std::size_t>(4, medium.layers.size() - 4 * j);
    if (medium.depths[j].image->channels.size() < needed)
      json.fail("depth_textures", medium.depths[j].path + " needs a channel for each of " + std::to_string(needed) +
                                      " layers, but has " + std::to_string(medium.depths[j].image->channels.size()));
  }
}

}  // namespace

std::shared_ptr<const LayeredMedium> read_layers(JsonObject json, const SceneContext& context) {
  auto medium = std::make_shared<LayeredMedium>();
  for (JsonObject& layer : json.objects("media")) medium->layers.push_back(read_layer(layer));
  if (medium->layers.empty() || medium->count() > LayeredMedium::most_layers)
    json.fail("media", "must be 1 to " + std::to_string(LayeredMedium::most_layers) + " layers, but is " +
                           std::to_string(medium->layers.size()));
  for (JsonObject& texture : json.objects("depth_textures")) medium->depths.push_back(read_depths(texture, context));
  medium->depth_scale = json.number_or("depth_scale_mm", Range::positive(), 1);
  json.finish();
  check_channels(*medium, json);
  if (!(medium->largest_depth() > 0)) json.fail("depth_textures", "are 0 everywhere: there is no layer");
  return medium;
}

}  // namespace opaline
