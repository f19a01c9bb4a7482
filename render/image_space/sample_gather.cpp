#include "render/image_space/sample_gather.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "render/image_space/sample_gather.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "model/profile_table_kernel.h"

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {

using D = TableTag;
using V = TableVector;
using Mask = hn::Mask<D>;
using Index = hn::Vec<hn::RebindToSigned<D>>;
constexpr D d;
constexpr hn::RebindToSigned<D> di;

HWY_INLINE V set(float x) { return hn::Set(d, x); }

/// Approximate reciprocals, refined once by Newton's method to single precision.
HWY_INLINE V reciprocal(V x) {
  const V y = hn::ApproximateReciprocal(x);
  return hn::MulAdd(y, hn::NegMulAdd(x, y, set(1)), y);
}
HWY_INLINE V reciprocal_root(V x) {
  const V y = hn::ApproximateReciprocalSqrt(x);
  return hn::Mul(y, hn::NegMulAdd(hn::Mul(hn::Mul(set(0.5f), x), y), y, set(1.5f)));
}

struct Vec3 {
  V x, y, z;
};
HWY_INLINE V dot(const Vec3& a, const Vec3& b) { return hn::MulAdd(a.x, b.x, hn::MulAdd(a.y, b.y, hn::Mul(a.z, b.z))); }
HWY_INLINE Vec3 sub(const Vec3& a, const Vec3& b) { return {hn::Sub(a.x, b.x), hn::Sub(a.y, b.y), hn::Sub(a.z, b.z)}; }
HWY_INLINE Vec3 broadcast(const glm::vec3& a) { return {set(a.x), set(a.y), set(a.z)}; }

/// The point to shade and the plane of its samples in the coordinates of one view.
struct LocalPoint {
  glm::vec3 position, tangent, bitangent, normal;
  float facing;  ///< |n . x| (perspective) or |n_z|: the part of 1 / G(p') that all of the plane shares
};

LocalPoint local_point(const Projection& view, const SampleGather& g, const glm::vec3& position,
                       const glm::vec3& normal) {
  const glm::vec3 x = view.point(position);
  const glm::vec3 to_viewer = view.perspective ? -glm::normalize(x) : glm::vec3(0, 0, -1);
  const TangentFrame frame = tangent_frame(turned_to(to_viewer, view.direction(normal), g.min_plane_cosine));
  return {x, frame.tangent, frame.bitangent, frame.normal,
          std::abs(view.perspective ? glm::dot(frame.normal, x) : frame.normal.z)};
}

/// A texel's plane met at a place of the film.
struct Texel {
  Mask valid;       ///< it sees the object
  Index at;         ///< of its first float
  V depth, sx, sy;  ///< depth at the very place; slopes
  V fx, fy;         ///< the place, from the texel's centre [pixels]
};

/// Texel under film place (px, py); not valid where `inside` isn't.
HWY_INLINE Texel fetch(const IrradianceMap& map, Mask inside, V px, V py) {
  inside = hn::And(inside, hn::And(hn::And(hn::Ge(px, hn::Zero(d)), hn::Lt(px, set(static_cast<float>(map.width)))),
                                   hn::And(hn::Ge(py, hn::Zero(d)), hn::Lt(py, set(static_cast<float>(map.height))))));
  px = hn::IfThenElseZero(inside, px), py = hn::IfThenElseZero(inside, py);
  const Index ix = hn::ConvertTo(di, px), iy = hn::ConvertTo(di, py);
  Texel texel;
  texel.at = hn::Mul(hn::Add(hn::Mul(iy, hn::Set(di, map.width)), ix), hn::Set(di, map.stride()));
  const float* t = map.texels.data();
  texel.sx = hn::GatherIndex(d, t + 1, texel.at), texel.sy = hn::GatherIndex(d, t + 2, texel.at);
  texel.fx = hn::Sub(hn::Sub(px, hn::ConvertTo(d, ix)), set(0.5f));
  texel.fy = hn::Sub(hn::Sub(py, hn::ConvertTo(d, iy)), set(0.5f));
  texel.depth = hn::MulAdd(texel.sx, texel.fx, hn::MulAdd(texel.sy, texel.fy, hn::GatherIndex(d, t, texel.at)));
  texel.valid = inside;
  return texel;
}

/// What one sample found in one view.
struct Found {
  Texel texel;
  Vec3 p;   ///< the surface point, in the view's coordinates
  V light;  ///< E G of the first channel
  V per_g;  ///< 1 / G(p'), or 1 without the Jacobian
};

template <bool Perspective>
HWY_INLINE Found project(const IrradianceMap& map, const LocalPoint& x, V u, V v, bool jacobian) {
  const Projection& view = map.projection;
  const Vec3 t = {hn::MulAdd(u, set(x.tangent.x), hn::MulAdd(v, set(x.bitangent.x), set(x.position.x))),
                  hn::MulAdd(u, set(x.tangent.y), hn::MulAdd(v, set(x.bitangent.y), set(x.position.y))),
                  hn::MulAdd(u, set(x.tangent.z), hn::MulAdd(v, set(x.bitangent.z), set(x.position.z)))};
  Found f;
  if constexpr (Perspective) {
    const Mask front = hn::Gt(t.z, set(1e-6f));
    const V per_z = reciprocal(hn::IfThenElse(front, t.z, set(1))), sx = hn::Mul(t.x, per_z), sy = hn::Mul(t.y, per_z);
    f.texel = fetch(map, front, hn::MulAdd(sx, set(view.scale), set(view.cx)),
                    hn::NegMulAdd(sy, set(view.scale), set(view.cy)));
    const V z = reciprocal(f.texel.depth);
    f.p = {hn::Mul(sx, z), hn::Mul(sy, z), z};
  } else {
    f.texel = fetch(map, hn::Ge(set(1), set(0)), hn::MulAdd(t.x, set(view.scale), set(view.cx)),
                    hn::NegMulAdd(t.y, set(view.scale), set(view.cy)));
    f.p = {t.x, t.y, f.texel.depth};
  }
  f.light = hn::GatherIndex(d, map.texels.data() + 3, f.texel.at);
  f.texel.valid = hn::And(f.texel.valid, hn::Ge(f.light, hn::Zero(d)));
  if (!jacobian) {
    f.per_g = set(1);
  } else if constexpr (Perspective) {
    const V per_d = reciprocal_root(dot(t, t));
    f.per_g = hn::Mul(hn::Mul(set(x.facing), per_d), hn::Mul(per_d, per_d));
  } else {
    f.per_g = set(x.facing);
  }
  return f;
}

/// A gather with the way its tables are looked up.
template <class Lookup>
struct Reader {
  const SampleGather& g;
  const Lookup& lookup;
  typename Lookup::Table tables[3];  ///< the distinct profiles

  Reader(const SampleGather& gather, const Lookup& way) : g(gather), lookup(way) {
    for (int t = 0; t < g.profiles.table_count; ++t) tables[t] = typename Lookup::Table(*g.profiles.tables[t], t);
  }

  template <int Tables>
  HWY_INLINE void values(const typename Lookup::Table* which, V r2, V (&value)[Tables]) const {
    const typename Lookup::Place place[1] = {lookup.place(r2)};
    V found[1][Tables];
    lookup.values(which, place, found);
    for (int t = 0; t < Tables; ++t) value[t] = found[0][t];
  }

  /// Density of the sets on the tangent plane at squared distance r2.
  HWY_INLINE V plane_density(V r2) const {
    V sum = hn::IfThenElseZero(hn::Lt(r2, set(g.density.disc_squared)), set(g.density.on_disc));
    for (int t = 0; t < g.profiles.table_count; ++t) {
      V value[1];
      values(tables + t, r2, value);
      sum = hn::MulAdd(set(g.density.per_table[t]), value[0], sum);
    }
    return sum;
  }
};

/// Outward normal of a texel's plane at its point p, in the view's coordinates. Its length is |m| of the plane
/// m . p = 1 (perspective), or the secant of its slope (orthographic).
HWY_INLINE Vec3 texel_normal(const Projection& view, const Texel& texel, const Vec3& p) {
  const V sx = hn::Mul(texel.sx, set(view.scale)), sy = hn::Mul(texel.sy, set(view.scale));
  if (!view.perspective) return {sx, hn::Neg(sy), set(-1)};
  const V per_z = hn::Div(set(1), p.z);
  const V mz = hn::Mul(per_z, hn::Sub(set(1), hn::Sub(hn::Mul(sx, p.x), hn::Mul(sy, p.y))));
  return {hn::Neg(sx), sy, hn::Neg(mz)};
}

/// D_v: area density on the surface with which a view's samples meet p, whose texel there is given.
template <class Lookup>
HWY_INLINE V area_density(const Reader<Lookup>& reader, const IrradianceMap& map, const LocalPoint& x, const Vec3& p,
                          const Texel& texel) {
  const Vec3 n = broadcast(x.normal), origin = broadcast(x.position), m = texel_normal(map.projection, texel, p);
  const V steepness = hn::Sqrt(dot(m, m));
  V per_j;
  Vec3 t = p;  // where the ray to p meets the tangent plane
  Mask meets;
  if (map.projection.perspective) {
    const V k = hn::Div(set(glm::dot(x.normal, x.position)), dot(n, p));
    meets = hn::Gt(k, hn::Zero(d));
    t = {hn::Mul(p.x, k), hn::Mul(p.y, k), hn::Mul(p.z, k)};
    // G(p) = |p|^3 |m|, so J = |m| |n . x| / k^3.
    per_j = hn::Div(hn::Mul(k, hn::Mul(k, k)), hn::Mul(steepness, set(std::max(x.facing, 1e-20f))));
  } else {
    const float nz = std::copysign(std::max(std::abs(x.normal.z), 1e-20f), x.normal.z);
    t.z = hn::Add(p.z, hn::Mul(dot(n, sub(origin, p)), set(1 / nz)));
    meets = hn::Ge(set(1), set(0));
    per_j = hn::Div(set(1 / std::abs(nz)), steepness);
  }
  const Vec3 offset = sub(t, origin);
  const V density = reader.plane_density(hn::Min(dot(offset, offset), set(1e30f)));
  return hn::IfThenElseZero(meets, reader.g.jacobian ? hn::Mul(density, per_j) : density);
}

/// Columns of a matrix times a vector.
HWY_INLINE Vec3 turned(const glm::mat3& m, const Vec3& v) {
  const auto row = [&](int i) HWY_ATTR {
    return hn::MulAdd(set(m[0][i]), v.x, hn::MulAdd(set(m[1][i]), v.y, hn::Mul(set(m[2][i]), v.z)));
  };
  return {row(0), row(1), row(2)};
}

/// D of another view for a point p of this one with an outward normal: 0 where the other doesn't see it.
template <class Lookup>
HWY_INLINE V other_density(const Reader<Lookup>& reader, const IrradianceMap& from, const IrradianceMap& to,
                           const LocalPoint& x, const Vec3& p, const Vec3& normal) {
  const Projection &a = from.projection, &b = to.projection;
  const glm::mat3 turn(b.to_camera * glm::transpose(a.to_camera));
  const glm::vec3 shift(b.to_camera * (a.origin - b.origin));
  const Vec3 q0 = turned(turn, p), n = turned(turn, normal);
  const Vec3 q = {hn::Add(q0.x, set(shift.x)), hn::Add(q0.y, set(shift.y)), hn::Add(q0.z, set(shift.z))};
  // The far side of something thin is no deeper than a pixel is wide, but it faces away.
  Mask seen = hn::Lt(b.perspective ? dot(n, q) : n.z, hn::Zero(d));
  if (b.perspective) seen = hn::And(seen, hn::Gt(q.z, set(1e-6f)));
  const V per_z = b.perspective ? hn::Div(set(1), hn::IfThenElse(seen, q.z, set(1))) : set(1);
  const V depth = b.perspective ? per_z : q.z;
  const Texel texel = fetch(to, seen, hn::MulAdd(hn::Mul(q.x, per_z), set(b.scale), set(b.cx)),
                            hn::NegMulAdd(hn::Mul(q.y, per_z), set(b.scale), set(b.cy)));
  seen = hn::And(texel.valid, hn::Ge(hn::GatherIndex(d, to.texels.data() + 3, texel.at), hn::Zero(d)));
  // At the depth of the texel, within what the depth changes over a pixel and a pixel's width.
  const V width = hn::Mul(hn::Abs(per_z), set(1 / b.scale));
  const V allowed = hn::Add(hn::Add(hn::Abs(texel.sx), hn::Abs(texel.sy)), width);
  seen = hn::And(seen, hn::Le(hn::Abs(hn::Sub(depth, texel.depth)), allowed));
  return hn::IfThenElseZero(seen, area_density(reader, to, x, q, texel));
}

/// The surface point in the middle of the texel that was found: one that the view really saw. (A plane is far off the
/// surface at the far end of a texel seen at a grazing angle, and no other view would know it.)
HWY_INLINE Vec3 texel_centre(const Projection& view, const Found& f) {
  const V depth = hn::NegMulAdd(f.texel.sx, f.texel.fx, hn::NegMulAdd(f.texel.sy, f.texel.fy, f.texel.depth));
  const V dx = hn::Mul(f.texel.fx, set(1 / view.scale)), dy = hn::Mul(f.texel.fy, set(1 / view.scale));
  if (!view.perspective) return {hn::Sub(f.p.x, dx), hn::Add(f.p.y, dy), depth};
  const V z = reciprocal(depth), per_z = reciprocal(f.p.z);
  return {hn::Mul(hn::MulSub(f.p.x, per_z, dx), z), hn::Mul(hn::MulAdd(f.p.y, per_z, dy), z), z};
}

/// Share of this view in what it found, over all views.
template <class Lookup>
HWY_INLINE V view_weight(const Reader<Lookup>& reader, std::size_t own, const LocalPoint* locals, const Found& f) {
  const SampleGather& g = reader.g;
  const Vec3 p = texel_centre(g.views[own].projection, f), normal = texel_normal(g.views[own].projection, f.texel, p);
  const V mine = area_density(reader, g.views[own], locals[own], p, f.texel);
  V sum = mine;
  for (std::size_t o = 0; o < g.views.size(); ++o)
    if (o != own && g.views[o].lit)
      sum = hn::Add(sum, other_density(reader, g.views[own], g.views[o], locals[o], p, normal));
  return hn::IfThenElse(hn::Gt(sum, set(0)), hn::Div(mine, hn::Max(sum, set(1e-37f))), set(0));
}

/// The point's own profiles at squared distances, where there is light.
HWY_INLINE void own_values(const Profile* const* own, V r2, Mask lit, V (&value)[3]) {
  constexpr std::size_t lanes = hn::MaxLanes(d);
  HWY_ALIGN float at[lanes], out[3][lanes] = {};
  hn::Store(hn::IfThenElse(lit, r2, set(-1)), d, at);
  for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
    if (at[lane] < 0) continue;
    const double r = std::sqrt(static_cast<double>(at[lane]));
    for (int c = 0; c < 3; ++c)
      out[c][lane] = c > 0 && own[c] == own[c - 1] ? out[c - 1][lane] : static_cast<float>(own[c]->evaluate(r));
  }
  for (int c = 0; c < 3; ++c) value[c] = hn::Load(d, out[c]);
}

HWY_INLINE float total(V sum) { return hn::GetLane(hn::SumOfLanes(d, sum)); }

/// Tables: distinct profiles against one irradiance channel; 0: three channels, each with its table.
template <bool Perspective, int Tables, class Lookup>
HWY_INLINE void gather_view(const Reader<Lookup>& reader, const SampleSet& set_of, std::size_t view,
                            const LocalPoint* locals, GatherResult& result) {
  constexpr int sums = Tables == 0 ? 3 : Tables;
  const SampleGather& g = reader.g;
  const IrradianceMap& map = g.views[view];
  const LocalPoint& x = locals[view];
  const Vec3 origin = broadcast(x.position);
  typename Lookup::Table tables[sums];
  for (int s = 0; s < sums; ++s) tables[s] = reader.tables[Tables == 0 ? g.profiles.table_of[s] : s];
  V sum[sums], valid[3] = {hn::Zero(d), hn::Zero(d), hn::Zero(d)};
  for (int s = 0; s < sums; ++s) sum[s] = hn::Zero(d);
  for (std::size_t i = 0; i < set_of.count; i += hn::Lanes(d)) {
    const V weight = hn::LoadU(d, &set_of.weight[i]);
    Found f = project<Perspective>(map, x, hn::LoadU(d, &set_of.u[i]), hn::LoadU(d, &set_of.v[i]), g.jacobian);
    f.texel.valid = hn::And(f.texel.valid, hn::Gt(weight, hn::Zero(d)));
    if (g.count_valid)
      for (int t = 0; t < g.profiles.table_count; ++t)
        valid[t] = hn::Add(valid[t], hn::IfThenElseZero(f.texel.valid, hn::LoadU(d, &set_of.share[t][i])));
    V light[3] = {f.light, f.light, f.light}, brightest = f.light;
    for (int c = 1; c < 3 && Tables == 0; ++c) {
      light[c] = hn::GatherIndex(d, map.texels.data() + 3 + c, f.texel.at);
      brightest = hn::Max(brightest, light[c]);
    }
    const Mask lit = hn::And(f.texel.valid, hn::Gt(brightest, hn::Zero(d)));
    result.met += hn::CountTrue(d, f.texel.valid);
    if (hn::AllFalse(d, lit)) continue;
    result.lit += hn::CountTrue(d, lit);
    result.looked_up += std::min(hn::Lanes(d), set_of.count - i);
    const Vec3 offset = sub(f.p, origin);
    const V r2 = hn::IfThenElseZero(lit, dot(offset, offset));
    V factor = hn::IfThenElseZero(lit, hn::Mul(weight, f.per_g));
    if (g.views.size() > 1) factor = hn::IfThenElseZero(lit, hn::Mul(factor, view_weight(reader, view, locals, f)));
    V profile[sums];
    bool own = false;
    if constexpr (Tables == 0) own = g.own[0] != nullptr;
    if constexpr (Tables == 0)
      if (own) own_values(g.own, r2, lit, profile);
    if (!own) reader.values(tables, r2, profile);
    for (int s = 0; s < sums; ++s) sum[s] = hn::MulAdd(hn::Mul(factor, light[s]), profile[s], sum[s]);
  }
  for (int s = 0; s < sums; ++s) result.sums[s] += total(sum[s]);
  for (int t = 0; t < g.profiles.table_count && g.count_valid; ++t) result.valid[t] += total(valid[t]);
}

template <int Tables, class Lookup>
HWY_INLINE void gather_views(const Reader<Lookup>& reader, const SampleSet& set_of, const LocalPoint* locals,
                             GatherResult& result) {
  for (std::size_t v = 0; v < reader.g.views.size(); ++v) {
    if (!reader.g.views[v].lit) continue;
    if (reader.g.views[v].projection.perspective)
      gather_view<true, Tables>(reader, set_of, v, locals, result);
    else
      gather_view<false, Tables>(reader, set_of, v, locals, result);
  }
}

void gather_samples(const SampleGather& g, const SampleSet& set_of, const glm::vec3& position, const glm::vec3& normal,
                    GatherResult& result) {
  LocalPoint locals[SampleGather::max_views];
  for (std::size_t v = 0; v < g.views.size(); ++v)
    if (g.views[v].lit) locals[v] = local_point(g.views[v].projection, g, position, normal);
  with_lookup(g.profiles.tables, g.profiles.table_count, [&]<class Lookup>(const Lookup& lookup) HWY_ATTR {
    const Reader<Lookup> reader(g, lookup);
    if (g.views[0].channels == 3) return gather_views<0>(reader, set_of, locals, result);
    if (g.profiles.table_count == 1) return gather_views<1>(reader, set_of, locals, result);
    if (g.profiles.table_count == 2) return gather_views<2>(reader, set_of, locals, result);
    gather_views<3>(reader, set_of, locals, result);
  });
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace opaline {

HWY_EXPORT(gather_samples);

void gather_samples(const SampleGather& gather, const SampleSet& set, const glm::vec3& position,
                    const glm::vec3& normal, GatherResult& result) {
  HWY_DYNAMIC_DISPATCH(gather_samples)(gather, set, position, normal, result);
}

TangentFrame tangent_frame(const glm::vec3& normal) {
  const glm::vec3 helper = std::abs(normal.x) < 0.5f ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0);
  const glm::vec3 tangent = glm::normalize(glm::cross(normal, helper));
  return {normal, tangent, glm::cross(normal, tangent)};
}

glm::vec3 turned_to(const glm::vec3& viewer, const glm::vec3& normal, float min_cosine) {
  const float cosine = glm::dot(viewer, normal);
  if (std::abs(cosine) >= min_cosine) return normal;
  const glm::vec3 side = normal - cosine * viewer;
  return std::copysign(min_cosine, cosine) * viewer + std::sqrt(1 - min_cosine * min_cosine) / glm::length(side) * side;
}

}  // namespace opaline
#endif
