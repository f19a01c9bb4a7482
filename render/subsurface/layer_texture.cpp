#include "render/subsurface/layer_texture.h"

namespace opaline {

LayerTexture make_layer_texture(const LayeredMedium& medium, std::size_t index, const std::vector<int>& layers) {
  const SurfaceTexture& source = medium.depths[index];
  const Image& image = *source.image;
  std::vector<int> channels;
  for (const int k : layers)
    if (static_cast<std::size_t>(k / 4) == index) channels.push_back(k % 4);
  LayerTexture t{image.width,
                 image.height,
                 static_cast<int>(channels.size()),
                 source.wrap,
                 source.filter == SurfaceTexture::Filter::nearest,
                 {}};
  if (channels.empty()) return t;
  const auto scale = static_cast<float>(medium.depth_scale);
  for (int y = -1; y <= t.height; ++y)
    for (int x = -1; x <= t.width; ++x) {
      const int column = wrapped_texel(x, t.width, t.wrap), line = wrapped_texel(y, t.height, t.wrap);
      for (std::size_t c = 0; c < 4; ++c)
        t.texels.push_back(c < channels.size() ? scale * image.at(column, image.height - 1 - line, channels[c]) : 0.0f);
    }
  return t;
}

}  // namespace opaline
