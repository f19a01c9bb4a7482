// Scenes of layered materials, for tests: layers of constant or varying depth over shapes.
#pragma once

#include "render/scene/texture_coordinates.h"
#include "tests/support/render_fixture.h"

namespace opaline::test {

/// The three layers of the paper's fish: dermis, blood, organs.
inline std::vector<SubsurfaceLayer> fish_layers() {
  return {{Rgb(2, 1, 1), Rgb(2.6, 1.6, 1.6), 0.25, Phase::schlick},
          {Rgb(6, 3, 2), Rgb(6.6, 3.6, 2.6), 0.40, Phase::schlick},
          {Rgb(1, 1, 2), Rgb(1.5, 1.5, 2.5), 0.80, Phase::schlick}};
}

/// A texture of depths, texel by texel and channel by channel.
inline SurfaceTexture depth_image(int width, int height, std::vector<float> values) {
  const std::vector<std::string> names = {"R", "G", "B", "A"};
  const auto channels = static_cast<int>(values.size()) / (width * height);
  Image image(width, height, {names.begin(), names.begin() + channels});
  image.data = std::move(values);
  return {"", std::make_shared<const Image>(image), SurfaceTexture::Wrap::repeat, SurfaceTexture::Filter::bilinear};
}

inline Material layered_material(std::vector<SubsurfaceLayer> layers, std::vector<SurfaceTexture> depths) {
  auto medium = std::make_shared<LayeredMedium>();
  medium->layers = std::move(layers);
  medium->depths = std::move(depths);
  Material material;
  material.name = "layered";
  material.layers = medium;
  return material;
}

/// Layers that end at the same depths everywhere [mm], four at most.
inline Material even_layers(std::vector<SubsurfaceLayer> layers, std::vector<float> depths) {
  return layered_material(std::move(layers), {depth_image(1, 1, std::move(depths))});
}

/// Depths with waves: dermis of 0.3, blood of 0 to 0.25, organs down to 3 mm.
inline Material wavy_layers() {
  std::vector<float> values;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      const float wave =
          std::max(0.0f, std::sin(0.4f * static_cast<float>(x)) * std::sin(0.4f * static_cast<float>(y)));
      values.insert(values.end(), {0.3f, 0.3f + 0.25f * wave, 2.0f + wave});
    }
  return layered_material(fish_layers(), {depth_image(32, 32, std::move(values))});
}

inline Scene layered_scene(Mesh mesh, Material material, double height, int pixels, UvProjection uvs) {
  make_texture_coordinates(mesh, uvs);
  return make_scene(std::move(mesh), std::move(material), height, pixels);
}

inline Frame render(const Scene& scene, const std::string& name, const std::map<std::string, std::string>& given = {}) {
  const Technique& technique = find_technique(name);
  const SharedScene shared(scene, {1, {}}, technique.needs_irradiance);
  return technique.prepare(shared, Settings(technique.settings, given))->render(shared.view);
}

}  // namespace opaline::test
