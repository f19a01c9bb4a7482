// An image laid over a surface by its texture coordinates.
//
// u grows to the right of the image and v upwards: (0, 0) is its lower left corner, (1, 1) its upper right one, and
// texel centres are at half steps. Values are linear, as read_image gives them.
#pragma once

#include "render/image.h"

#include <glm/glm.hpp>

#include <memory>
#include <string>

namespace opaline {

struct SurfaceTexture {
  enum class Wrap { repeat, clamp, mirror };  ///< outside [0, 1]
  enum class Filter { bilinear, nearest };

  std::string path;                    ///< for messages
  std::shared_ptr<const Image> image;  ///< at least one pixel
  Wrap wrap = Wrap::repeat;
  Filter filter = Filter::bilinear;

  /// The first `count` channels at uv (finite), into out.
  void sample(const glm::vec2& uv, int count, float* out) const;
};

/// Column or row i of an image of n, brought into it.
int wrapped_texel(int i, int n, SurfaceTexture::Wrap wrap);

}  // namespace opaline
