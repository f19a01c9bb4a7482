#include "render/scene/surface_texture.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Wrap = SurfaceTexture::Wrap;

/// Column or row i of n, brought into the image.
int wrapped(int i, int n, Wrap wrap) {
  if (wrap == Wrap::clamp) return std::clamp(i, 0, n - 1);
  const int period = wrap == Wrap::mirror ? 2 * n : n;
  const int at = (i % period + period) % period;
  return at < n ? at : period - 1 - at;
}

/// Texture coordinates far outside say nothing; they must not overflow an integer.
float bounded(float x) { return std::clamp(x, -1e6f, 1e6f); }

}  // namespace

void SurfaceTexture::sample(const glm::vec2& uv, int count, float* out) const {
  const int w = image->width, h = image->height;
  const auto texel = [&](int x, int y) {
    return &image->data[image->index(wrapped(x, w, wrap), h - 1 - wrapped(y, h, wrap), 0)];
  };
  float x = bounded(uv.x) * static_cast<float>(w), y = bounded(uv.y) * static_cast<float>(h);
  if (filter == Filter::nearest) {
    std::copy_n(texel(static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))), count, out);
    return;
  }
  x -= 0.5f, y -= 0.5f;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const float fx = x - std::floor(x), fy = y - std::floor(y);
  const float *a = texel(x0, y0), *b = texel(x0 + 1, y0), *c = texel(x0, y0 + 1), *d = texel(x0 + 1, y0 + 1);
  for (int k = 0; k < count; ++k) {
    const float low = a[k] + fx * (b[k] - a[k]), high = c[k] + fx * (d[k] - c[k]);
    out[k] = low + fy * (high - low);
  }
}

}  // namespace opaline
