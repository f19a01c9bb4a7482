// The types and functions of march.glsl as vectors: one lane a point of the surface. Include inside foreach_target
// files only.
//
// Errors, relative: inverse_root and a / b 5e-7, exp_minus 2e-7. Divisors and inverse_root's arguments are normal
// numbers.
#if defined(OPALINE_MARCH_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OPALINE_MARCH_LANES_H
#undef OPALINE_MARCH_LANES_H
#else
#define OPALINE_MARCH_LANES_H
#endif

#include <hwy/highway.h>
#include <glm/glm.hpp>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, 16>;
using IntLanes = hn::RebindToSigned<Lanes>;

struct Real {
  hn::Vec<Lanes> v;

  Real() = default;
  HWY_INLINE Real(hn::Vec<Lanes> lanes) : v(lanes) {}   // NOLINT: as in a shader, numbers
  HWY_INLINE Real(float x) : v(hn::Set(Lanes(), x)) {}  // NOLINT: go where lanes go
  HWY_INLINE explicit Real(const float* p) : v(hn::Load(Lanes(), p)) {}
};

struct Mask {
  hn::Mask<Lanes> m;

  Mask() = default;
  HWY_INLINE Mask(hn::Mask<Lanes> lanes) : m(lanes) {}  // NOLINT: what comparisons give
  HWY_INLINE explicit Mask(bool b) : m(hn::Eq(hn::Zero(Lanes()), hn::Set(Lanes(), b ? 0.0f : 1.0f))) {}
};

struct Bits {
  hn::Vec<IntLanes> v;

  Bits() = default;
  HWY_INLINE explicit Bits(const std::int32_t* p) : v(hn::Load(IntLanes(), p)) {}
  HWY_INLINE Mask has(int bit) const {
    const hn::Vec<IntLanes> one = hn::Set(IntLanes(), 1 << bit);
    return hn::RebindMask(Lanes(), hn::Eq(hn::And(v, one), one));
  }
  HWY_INLINE Mask any() const { return hn::RebindMask(Lanes(), hn::Ne(v, hn::Zero(IntLanes()))); }
};

HWY_INLINE Mask operator&&(Mask a, Mask b) { return hn::And(a.m, b.m); }
HWY_INLINE Mask operator||(Mask a, Mask b) { return hn::Or(a.m, b.m); }
HWY_INLINE Mask operator!=(Mask a, Mask b) { return hn::Xor(a.m, b.m); }
HWY_INLINE Mask operator!(Mask a) { return hn::Not(a.m); }
HWY_INLINE bool some(Mask a) { return !hn::AllFalse(Lanes(), a.m); }

HWY_INLINE Real operator+(Real a, Real b) { return hn::Add(a.v, b.v); }
HWY_INLINE Real operator-(Real a, Real b) { return hn::Sub(a.v, b.v); }
HWY_INLINE Real operator*(Real a, Real b) { return hn::Mul(a.v, b.v); }
HWY_INLINE Real operator-(Real a) { return hn::Neg(a.v); }
HWY_INLINE Real& operator+=(Real& a, Real b) { return a = a + b; }
HWY_INLINE Real& operator-=(Real& a, Real b) { return a = a - b; }

HWY_INLINE Mask operator<(Real a, Real b) { return hn::Lt(a.v, b.v); }
HWY_INLINE Mask operator>(Real a, Real b) { return hn::Gt(a.v, b.v); }
HWY_INLINE Mask operator<=(Real a, Real b) { return hn::Le(a.v, b.v); }
HWY_INLINE Mask operator>=(Real a, Real b) { return hn::Ge(a.v, b.v); }

HWY_INLINE Real min(Real a, Real b) { return hn::Min(a.v, b.v); }
HWY_INLINE Real max(Real a, Real b) { return hn::Max(a.v, b.v); }
HWY_INLINE Real abs(Real a) { return hn::Abs(a.v); }
HWY_INLINE Real floor(Real a) { return hn::Floor(a.v); }
HWY_INLINE Real clamp(Real a, Real low, Real high) { return hn::Min(hn::Max(a.v, low.v), high.v); }
HWY_INLINE Real choose(Mask m, Real a, Real b) { return hn::IfThenElse(m.m, a.v, b.v); }

/// By Newton's method from the processor's guess, where that has eleven bits or more.
HWY_INLINE Real operator/(Real a, Real b) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Div(a.v, b.v);
#else
  const Real guess = hn::ApproximateReciprocal(b.v);
  return a * (guess * (2.0f - b * guess));
#endif
}
HWY_INLINE Real inverse_root(Real a) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Div(Real(1.0f).v, hn::Sqrt(a.v));
#else
  const Real guess = hn::ApproximateReciprocalSqrt(a.v);
  return guess * (1.5f - 0.5f * a * guess * guess);
#endif
}

/// e^-x for x >= 0; beyond 86 as there.
HWY_INLINE Real exp_minus(Real x) {
  const Real bounded = min(x, 86.0f), magic = 12582912.0f;  // 1.5 * 2^23: adding it leaves n = round(-x / ln 2)
  const Real shifted = magic - bounded * 1.44269504f, n = shifted - magic;
  const Real r = (-bounded - n * 0.693145752f) - n * 1.42860677e-6f;  // 15 bits of ln 2, and the rest
  Real p = 0.0013942759f;  // interpolates exp at Chebyshev nodes of |r| < 0.352, error 3e-9
  for (const float c : {0.0083764482f, 0.0416663328f, 0.1666639939f, 0.5f, 1.0f, 1.0f}) p = p * r + c;
  const IntLanes di;
  return hn::BitCast(Lanes(), hn::Add(hn::BitCast(di, p.v), hn::ShiftLeft<23>(hn::BitCast(di, shifted.v))));
}

struct Real2 {
  Real x, y;

  Real2() = default;
  HWY_INLINE Real2(Real first, Real second) : x(first), y(second) {}
};
HWY_INLINE Real2 operator+(const Real2& a, const Real2& b) { return {a.x + b.x, a.y + b.y}; }
HWY_INLINE Real2 operator*(const Real2& a, Real b) { return {a.x * b, a.y * b}; }

HWY_INLINE Real2 choose(Mask m, const Real2& a, const Real2& b) { return {choose(m, a.x, b.x), choose(m, a.y, b.y)}; }

struct Real3 {
  Real x, y, z;

  Real3() = default;
  HWY_INLINE explicit Real3(Real all) : x(all), y(all), z(all) {}
  HWY_INLINE Real3(Real first, Real second, Real third) : x(first), y(second), z(third) {}
  HWY_INLINE Real3(const glm::vec3& a) : x(a.x), y(a.y), z(a.z) {}  // NOLINT: the same for all lanes
};
HWY_INLINE Real3 operator+(const Real3& a, const Real3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
HWY_INLINE Real3 operator-(const Real3& a, const Real3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HWY_INLINE Real3 operator*(const Real3& a, const Real3& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
HWY_INLINE Real3 operator*(const Real3& a, Real b) { return {a.x * b, a.y * b, a.z * b}; }
HWY_INLINE Real3 operator*(Real a, const Real3& b) { return b * a; }
HWY_INLINE Real3& operator+=(Real3& a, const Real3& b) { return a = a + b; }
HWY_INLINE Real3& operator*=(Real3& a, const Real3& b) { return a = a * b; }
HWY_INLINE Real dot(const Real3& a, const Real3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
HWY_INLINE Real3 exp_minus(const Real3& a) { return {exp_minus(a.x), exp_minus(a.y), exp_minus(a.z)}; }
HWY_INLINE Real3 choose(Mask m, const Real3& a, const Real3& b) {
  return {choose(m, a.x, b.x), choose(m, a.y, b.y), choose(m, a.z, b.z)};
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
