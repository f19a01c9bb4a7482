// A texture of depths laid out for marches, which read it for many places at once.
#pragma once

#include "render/scene/layered_medium.h"

namespace opaline {

/// Texels of four depths each [mm], rows from v = 0 upwards, within a frame of one texel of what lies beyond.
struct LayerTexture {
  int width = 0, height = 0;  ///< without the frame
  int layers = 0;             ///< how many of the four depths mean something: the first
  SurfaceTexture::Wrap wrap = SurfaceTexture::Wrap::repeat;
  bool nearest = false;
  std::vector<float> texels;

  int stride() const { return 4 * (width + 2); }
};

/// What textures[index] of a medium says of some of the medium's layers; empty if none of them is in it.
LayerTexture make_layer_texture(const LayeredMedium& medium, std::size_t index, const std::vector<int>& layers);

}  // namespace opaline
