// The two-point rule of patches.h for a vector of patches. Include inside HWY_NAMESPACE only.
#if defined(OPALINE_TWO_POINTS_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OPALINE_TWO_POINTS_H
#undef OPALINE_TWO_POINTS_H
#else
#define OPALINE_TWO_POINTS_H
#endif

#include "render/irradiance/patches.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class V>
struct TwoPoints {
  V dx, dy, dz;         ///< query minus centroid [mm]
  V near, far, spread;  ///< q0 - s (>= 0), q0 + s, s [mm^2]
};

/// Square root by one Newton step, relative error below 5e-7; 0 below 1e-36. A true one takes longer than all the rest.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V fast_sqrt(D d, V x) {
#if HWY_TARGET == HWY_SCALAR  // its guess has eight bits only
  return hn::Sqrt(hn::Max(x, hn::Zero(d)));
#endif
  const V y = hn::Max(x, hn::Set(d, 1e-36f)), guess = hn::ApproximateReciprocalSqrt(y), root = hn::Mul(y, guess);
  const V corrected = hn::Mul(root, hn::NegMulAdd(hn::Mul(root, guess), hn::Set(d, 0.5f), hn::Set(d, 1.5f)));
  return hn::IfThenElseZero(hn::Gt(x, hn::Set(d, 1e-36f)), corrected);
}

template <class D, class V = hn::Vec<D>>
HWY_INLINE TwoPoints<V> two_points(D d, const PatchList& patches, std::size_t i, const glm::vec3& position) {
  TwoPoints<V> r;
  r.dx = hn::Sub(hn::Set(d, position.x), hn::LoadU(d, patches.row(0) + i));
  r.dy = hn::Sub(hn::Set(d, position.y), hn::LoadU(d, patches.row(1) + i));
  r.dz = hn::Sub(hn::Set(d, position.z), hn::LoadU(d, patches.row(2) + i));
  const V xx = hn::LoadU(d, patches.row(3) + i), xy = hn::LoadU(d, patches.row(4) + i),
          xz = hn::LoadU(d, patches.row(5) + i), yy = hn::LoadU(d, patches.row(6) + i),
          yz = hn::LoadU(d, patches.row(7) + i), zz = hn::LoadU(d, patches.row(8) + i),
          trace = hn::LoadU(d, patches.row(9) + i);
  // D^T C D with the off-diagonal terms counted twice.
  const V x2 = hn::Add(r.dx, r.dx), y2 = hn::Add(r.dy, r.dy);
  const V along_x = hn::MulAdd(xx, hn::Mul(r.dx, r.dx), hn::Mul(x2, hn::MulAdd(xy, r.dy, hn::Mul(xz, r.dz))));
  const V along_y = hn::MulAdd(yy, hn::Mul(r.dy, r.dy), hn::Mul(y2, hn::Mul(yz, r.dz)));
  const V along = hn::Add(hn::Add(along_x, along_y), hn::Mul(zz, hn::Mul(r.dz, r.dz)));
  const V variance = hn::MulAdd(hn::Set(d, 4.0f), along, hn::Mul(trace, hn::Mul(trace, hn::Set(d, 1.0f / 3))));
  r.spread = fast_sqrt(d, variance);
  const V middle = hn::Add(hn::MulAdd(r.dx, r.dx, hn::MulAdd(r.dy, r.dy, hn::Mul(r.dz, r.dz))), trace);
  r.near = hn::Max(hn::Sub(middle, r.spread), hn::Zero(d));
  r.far = hn::Add(middle, r.spread);
  return r;
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
