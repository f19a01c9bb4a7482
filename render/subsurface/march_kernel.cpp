#include "render/subsurface/march.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/subsurface/march_kernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "render/subsurface/march_lanes.h"

#include <algorithm>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

constexpr std::size_t most_points = hn::MaxLanes(Lanes());

/// Where to read a texture, and how far from the texel on to the next.
struct TexelPlaces {
  HWY_ALIGN std::int32_t at[most_points];
  HWY_ALIGN float x[most_points], y[most_points];
};

/// A coordinate in texels, from 1/2 before the first, and brought into the image's frame.
HWY_INLINE Real texel_coordinate(Real u, int size, SurfaceTexture::Wrap wrap) {
  Real in = clamp(u, -1e6f, 1e6f);  // far outside it says nothing, and must not overflow an integer
  if (wrap == SurfaceTexture::Wrap::repeat) in = in - floor(in);
  if (wrap == SurfaceTexture::Wrap::mirror) in = in - 2.0f * floor(0.5f * in);
  if (wrap == SurfaceTexture::Wrap::mirror) in = min(in, 2.0f - in);
  return clamp(in, 0.0f, 1.0f) * static_cast<float>(size);
}

HWY_INLINE void find_texels(const LayerTexture& texture, const Real2& uv, TexelPlaces& places) {
  const Lanes d;
  const IntLanes di;
  Real x = texel_coordinate(uv.x, texture.width, texture.wrap),
       y = texel_coordinate(uv.y, texture.height, texture.wrap);
  // In the frame, whose first texel is number 0; nearest: the last texel ends at 1, which is in it.
  const float half = texture.nearest ? 1.0f : 0.5f;
  x = min(x + half, static_cast<float>(texture.width) + 0.5f),
  y = min(y + half, static_cast<float>(texture.height) + 0.5f);
  const auto column = hn::ConvertTo(di, x.v), row = hn::ConvertTo(di, y.v);
  const auto at = hn::Add(hn::Mul(row, hn::Set(di, texture.stride())), hn::ShiftLeft<2>(column));
  hn::Store(at, di, places.at);
  const float between = texture.nearest ? 0.0f : 1.0f;
  hn::Store((between * (x - hn::ConvertTo(d, column))).v, d, places.x);
  hn::Store((between * (y - hn::ConvertTo(d, row))).v, d, places.y);
}

/// The texture's four depths at each place, between texels. All four of a texel are one load; a gather takes longer.
HWY_INLINE void read_texture(const LayerTexture& texture, const Real2& uv, Real (&depth)[4]) {
  const hn::CappedTag<float, 4> d4;
  TexelPlaces places;
  find_texels(texture, uv, places);
  HWY_ALIGN float found[4 * most_points];
  const auto next_row = static_cast<std::size_t>(texture.stride());
  for (std::size_t i = 0; i < hn::Lanes(Lanes()); ++i)
    for (std::size_t c = 0; c < 4; c += hn::Lanes(d4)) {
      const float* t = &texture.texels[static_cast<std::size_t>(places.at[i]) + c];
      const auto x = hn::Set(d4, places.x[i]), y = hn::Set(d4, places.y[i]);
      const auto a = hn::LoadU(d4, t), b = hn::LoadU(d4, t + next_row);
      const auto low = hn::MulAdd(x, hn::Sub(hn::LoadU(d4, t + 4), a), a),
                 high = hn::MulAdd(x, hn::Sub(hn::LoadU(d4, t + next_row + 4), b), b);
      hn::Store(hn::MulAdd(y, hn::Sub(high, low), low), d4, found + 4 * i + c);
    }
  hn::LoadInterleaved4(Lanes(), found, depth[0].v, depth[1].v, depth[2].v, depth[3].v);
}

/// As many points as there are lanes, the last again and again where there are fewer.
struct PointBlock {
  static constexpr std::size_t fields = 23, far_fields = 6;
  HWY_ALIGN float field[fields][most_points];
  HWY_ALIGN float far[most_march_lights][far_fields][most_points];
  HWY_ALIGN std::int32_t seen[most_points];

  HWY_INLINE void read(const MarchPoint* points, std::size_t count, std::size_t lights) {
    for (std::size_t i = 0; i < hn::Lanes(Lanes()); ++i) {
      const MarchPoint& p = points[std::min(i, count - 1)];
      std::size_t f = 0;
      for (const glm::vec3* v : {&p.position, &p.normal, &p.w_o, &p.plane_normal, &p.gradient_u, &p.gradient_v})
        for (int c = 0; c < 3; ++c) field[f++][i] = (*v)[c];
      for (const float x : {p.plane_height, p.uv.x, p.uv.y, p.exit, p.exit_cosine}) field[f++][i] = x;
      seen[i] = static_cast<std::int32_t>(p.lights);
      for (std::size_t l = 0; l < lights; ++l) read_far(p.far.empty() ? FarSide{} : p.far[l], l, i);
    }
  }

  HWY_INLINE void read_far(const FarSide& side, std::size_t light, std::size_t lane) {
    std::size_t f = 0;
    for (const float x : {side.normal.x, side.normal.y, side.normal.z, side.height, side.uv.x, side.uv.y})
      far[light][f++][lane] = x;
  }

  HWY_INLINE Real3 vector(std::size_t f) const { return {Real(field[f]), Real(field[f + 1]), Real(field[f + 2])}; }
  HWY_INLINE Real number(std::size_t f) const { return Real(field[f]); }
};

/// The march of march.glsl with what it is given. MostLayers: room for them.
template <int MostLayers>
struct MarchKernel {
  static constexpr int most_layers = MostLayers, most_lights = most_march_lights;

  struct Depths {
    Real of[most_layers];
  };
  struct FarSide {
    Real3 normal;
    Real height;
    Real2 uv;
  };

  const MarchMedium& medium;
  const int layers, lights, samples;
  const bool by_pieces;
  const float largest_depth, negligible;
  const glm::vec3 *sigma_s, *sigma_t;
  const glm::vec4* phase_of;
  glm::vec3 light_place[most_lights], light_power[most_lights];
  float light_far[most_lights];
  PointBlock block;  ///< of the points that march now

  MarchKernel(const MarchMedium& m, std::span<const MarchLight> given, const MarchSettings& settings)
      : medium(m),
        layers(m.stack.count),
        lights(static_cast<int>(given.size())),
        samples(settings.samples),
        by_pieces(settings.by_pieces),
        largest_depth(m.largest_depth),
        negligible(settings.negligible),
        sigma_s(m.stack.sigma_s.data()),
        sigma_t(m.stack.sigma_t.data()),
        phase_of(m.phases.data()) {
    for (std::size_t l = 0; l < given.size(); ++l)
      light_place[l] = given[l].place, light_power[l] = given[l].power, light_far[l] = given[l].far ? 1.0f : 0.0f;
  }

  HWY_INLINE static Mask sees(Bits seen, int light) { return seen.has(light); }
  HWY_INLINE static Mask sees_any(Bits seen) { return seen.any(); }

  HWY_INLINE Depths boundaries(const Real2& uv) const {
    Depths depths;
    Real above = 0.0f;
    int k = 0;
    for (const LayerTexture& texture : medium.textures) {
      Real found[4];
      read_texture(texture, uv, found);
      for (int c = 0; c < texture.layers; ++c) depths.of[k++] = above = max(above, found[c]);
    }
    return depths;
  }

  HWY_INLINE FarSide far_side(int light) const {
    const auto& f = block.far[light];
    return {Real3(Real(f[0]), Real(f[1]), Real(f[2])), Real(f[3]), Real2(Real(f[4]), Real(f[5]))};
  }

#define FORMULA HWY_INLINE
#define IN(type) const type&
#define INOUT(type) type&
#include "render/subsurface/march.glsl"

  HWY_INLINE March march_block(const MarchPoint* points, std::size_t count) {
    block.read(points, count, static_cast<std::size_t>(lights));
    return march({block.vector(0), block.vector(3), block.vector(6), block.vector(9), block.vector(12),
                  block.vector(15), block.number(18), Real2(block.number(19), block.number(20)), block.number(21),
                  block.number(22), Bits(block.seen)});
  }
#undef FORMULA
#undef IN
#undef INOUT
};

template <typename March>
HWY_INLINE void store(const March& m, std::size_t count, MarchResult* results) {
  const Real values[] = {m.sum.x, m.sum.y, m.sum.z, m.steps, m.light_paths, m.from_behind, m.deepest};
  HWY_ALIGN float lanes[std::size(values)][most_points];
  for (std::size_t v = 0; v < std::size(values); ++v) hn::Store(values[v].v, Lanes(), lanes[v]);
  for (std::size_t i = 0; i < count; ++i)
    results[i] = {{lanes[0][i], lanes[1][i], lanes[2][i]}, lanes[3][i], lanes[4][i], lanes[5][i], lanes[6][i]};
}

template <class Kernel>
HWY_NOINLINE void march_all(Kernel& kernel, std::span<const MarchPoint> points, MarchResult* results) {
  const std::size_t lanes = hn::Lanes(Lanes());
  for (std::size_t i = 0; i < points.size(); i += lanes) {
    const std::size_t count = std::min(lanes, points.size() - i);
    store(kernel.march_block(&points[i], count), count, results + i);
  }
}

void march_points(std::span<const MarchPoint> points, const MarchMedium& medium, std::span<const MarchLight> lights,
                  const MarchSettings& settings, MarchResult* results) {
  if (medium.stack.count <= 4) {
    MarchKernel<4> kernel(medium, lights, settings);
    return march_all(kernel, points, results);
  }
  MarchKernel<LayeredMedium::most_layers> kernel(medium, lights, settings);
  march_all(kernel, points, results);
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(march_points);

void march(std::span<const MarchPoint> points, const MarchMedium& medium, std::span<const MarchLight> lights,
           const MarchSettings& settings, MarchResult* results) {
  HWY_DYNAMIC_DISPATCH(march_points)(points, medium, lights, settings, results);
}

}  // namespace opaline
#endif
