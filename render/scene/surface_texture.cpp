#include "render/scene/surface_texture.h"

#include <algorithm>

namespace opaline {
namespace {

using Wrap = SurfaceTexture::Wrap;

/// std::floor is a call where processors of the least kind are built for.
int floor_of(float x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero - (x < static_cast<float>(towards_zero));
}

/// Texture coordinates far outside say nothing; they must not overflow an integer.
float bounded(float x) { return std::clamp(x, -1e6f, 1e6f); }

}  // namespace

int wrapped_texel(int i, int n, Wrap wrap) {
  if (static_cast<unsigned>(i) < static_cast<unsigned>(n)) return i;
  if (wrap == Wrap::clamp) return std::clamp(i, 0, n - 1);
  const int period = wrap == Wrap::mirror ? 2 * n : n;
  const int at = (i % period + period) % period;
  return at < n ? at : period - 1 - at;
}

void SurfaceTexture::sample(const glm::vec2& uv, int count, float* out) const {
  const int w = image->width, h = image->height;
  const auto texel = [&](int x, int y) {
    return &image->data[image->index(wrapped_texel(x, w, wrap), h - 1 - wrapped_texel(y, h, wrap), 0)];
  };
  float x = bounded(uv.x) * static_cast<float>(w), y = bounded(uv.y) * static_cast<float>(h);
  if (filter == Filter::nearest) {
    std::copy_n(texel(floor_of(x), floor_of(y)), count, out);
    return;
  }
  x -= 0.5f, y -= 0.5f;
  const int x0 = floor_of(x), y0 = floor_of(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const float *a = texel(x0, y0), *b = texel(x0 + 1, y0), *c = texel(x0, y0 + 1), *d = texel(x0 + 1, y0 + 1);
  for (int k = 0; k < count; ++k) {
    const float low = a[k] + fx * (b[k] - a[k]), high = c[k] + fx * (d[k] - c[k]);
    out[k] = low + fy * (high - low);
  }
}

}  // namespace opaline
