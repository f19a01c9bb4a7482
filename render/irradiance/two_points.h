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
  V dx, dy, dz;  ///< query minus centroid [mm]
  V near, far;   ///< the two values of q, near < far, near >= 0 [mm^2]
  V spread;      ///< half their distance [mm^2]
  V tilt;        ///< near weighs 1/2 + tilt, far 1/2 - tilt
};

/// 1 / sqrt(x) by one Newton step, relative error below 5e-7; x > 0. A true root takes longer than all the rest.
template <class D, class V = hn::Vec<D>>
HWY_INLINE V fast_inverse_sqrt(D d, V x) {
#if HWY_TARGET == HWY_SCALAR  // its guess has eight bits only
  return hn::Div(hn::Set(d, 1.0f), hn::Sqrt(x));
#else
  const V guess = hn::ApproximateReciprocalSqrt(x);
  const V half = hn::Mul(hn::Mul(hn::Set(d, 0.5f), x), guess);
  return hn::Mul(guess, hn::NegMulAdd(half, guess, hn::Set(d, 1.5f)));
#endif
}

/// E (x . delta)^3 and E (x . delta) |delta|^2 of the patches at x = D.
template <class V>
struct ThirdMoments {
  V cubic, radial;
};

template <class D, class Geometry, class V = hn::Vec<D>>
HWY_INLINE ThirdMoments<V> third_moments(D d, const Geometry& geometry, const TwoPoints<V>& r, V xx, V yy, V zz) {
  V k[10];
  for (int m = 0; m < 10; ++m) k[m] = geometry(11 + m);
  const V yz = hn::Mul(r.dy, r.dz), third = hn::Set(d, 1.0f / 3);
  // Ordered by powers of x, y, z: xxx xxy xxz xyy xyz xzz yyy yyz yzz zzz.
  const V with_xx = hn::MulAdd(k[0], r.dx, hn::MulAdd(k[1], r.dy, hn::Mul(k[2], r.dz)));
  const V with_x = hn::MulAdd(k[3], yy, hn::MulAdd(k[4], yz, hn::Mul(k[5], zz)));
  const V with_yy = hn::MulAdd(k[6], r.dy, hn::Mul(k[7], r.dz));
  const V with_zz = hn::MulAdd(k[8], r.dy, hn::Mul(k[9], r.dz));
  const V cubic = hn::MulAdd(with_xx, xx, hn::MulAdd(with_x, r.dx, hn::MulAdd(with_yy, yy, hn::Mul(with_zz, zz))));
  // The Laplacian of the cubic, over 6.
  const V tx = hn::MulAdd(third, hn::Add(k[3], k[5]), k[0]), ty = hn::MulAdd(third, hn::Add(k[1], k[8]), k[6]),
          tz = hn::MulAdd(third, hn::Add(k[2], k[7]), k[9]);
  return {cubic, hn::MulAdd(tx, r.dx, hn::MulAdd(ty, r.dy, hn::Mul(tz, r.dz)))};
}

/// c(row): row of the patches' geometry, as PatchList numbers them.
template <class D, class Geometry, class V = hn::Vec<D>>
HWY_INLINE TwoPoints<V> two_points(D d, const Geometry& c, const glm::vec3& position) {
  TwoPoints<V> r;
  r.dx = hn::Sub(hn::Set(d, position.x), c(0));
  r.dy = hn::Sub(hn::Set(d, position.y), c(1));
  r.dz = hn::Sub(hn::Set(d, position.z), c(2));
  const V xx = hn::Mul(r.dx, r.dx), yy = hn::Mul(r.dy, r.dy), zz = hn::Mul(r.dz, r.dz);
  // D^T C D with the off-diagonal terms counted twice.
  const V mixed = hn::MulAdd(hn::MulAdd(c(4), r.dy, hn::Mul(c(5), r.dz)), r.dx, hn::Mul(hn::Mul(c(7), r.dy), r.dz));
  const V pure = hn::MulAdd(c(3), xx, hn::MulAdd(c(6), yy, hn::Mul(c(8), zz)));
  const V along = hn::MulAdd(hn::Set(d, 2.0f), mixed, pure);
  const V trace = c(9);
  const ThirdMoments<V> third = third_moments(d, c, r, xx, yy, zz);
  // The floor is for cancellation: the parts are known to 1e-6, and padding has none.
  const V parts = hn::MulAdd(hn::Set(d, 4.0f), along, c(10));
  const V floor = hn::MulAdd(hn::Set(d, 1e-5f), parts, hn::Set(d, 1e-36f));
  const V variance = hn::Max(hn::NegMulAdd(hn::Set(d, 4.0f), third.radial, parts), floor);
  const V skew = hn::MulAdd(hn::Mul(hn::Set(d, 4.0f), trace), along, hn::Mul(hn::Set(d, -8.0f), third.cubic));
  const V guess = hn::ApproximateReciprocal(variance);  // followed by a Newton step
  const V half_gamma =
      hn::Mul(hn::Mul(skew, guess), hn::NegMulAdd(hn::Mul(hn::Set(d, 0.5f), variance), guess, hn::Set(d, 1.0f)));
  const V square = hn::MulAdd(half_gamma, half_gamma, variance), per_spread = fast_inverse_sqrt(d, square);
  r.spread = hn::Mul(square, per_spread);
  r.tilt = hn::Mul(hn::Set(d, 0.5f), hn::Mul(half_gamma, per_spread));
  const V square_distance = hn::Add(xx, hn::Add(yy, zz));
  const V middle = hn::Add(square_distance, hn::Add(trace, half_gamma));
  const V distance = hn::Mul(square_distance, fast_inverse_sqrt(d, hn::Add(square_distance, hn::Set(d, 1e-36f))));
  const V gap = hn::Max(hn::Sub(distance, c(21)), hn::Zero(d)), reach = hn::Add(distance, c(21));
  r.near = hn::Max(hn::Sub(middle, r.spread), hn::Mul(gap, gap));
  r.far = hn::Min(hn::Add(middle, r.spread), hn::Mul(reach, reach));
  return r;
}

template <class D>
struct ListedPatches {
  const PatchList& patches;
  std::size_t first;
  HWY_INLINE hn::Vec<D> operator()(int row) const { return hn::LoadU(D(), patches.geometry(row, first)); }
};

template <class D, class V = hn::Vec<D>>
HWY_INLINE TwoPoints<V> two_points(D d, const PatchList& patches, std::size_t i, const glm::vec3& position) {
  return two_points(d, ListedPatches<D>{patches, i}, position);
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
