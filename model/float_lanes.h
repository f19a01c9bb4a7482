// Vectors of floats, each with the rounding error it carries: the scalar type with which a formula runs on vector lanes
// and still loses nothing where it matters, in the argument of an exponential. Include inside foreach_target files
// only.
//
// A number is hi + lo. Sums and products compute lo exactly to first order but never renormalise, so hi never depends
// on lo and the compiler drops every lo that nobody reads: only sqrt and exp do. hi alone is the result. Two vectors go
// side by side, so that the latencies of one hide behind the other.
//
// Accuracy: sqrt relative 1e-12 (hi + lo), inverse_sqrt 1e-7, exp 1e-7 plus the error of its argument. Arguments must
// keep all intermediate results within [1e-37, 1e38]; 0 is allowed. Targets without fused multiply-adds get the
// rounding error of a product by splitting, and are slow.
#if defined(OPALINE_FLOAT_LANES_H) == defined(HWY_TARGET_TOGGLE)
#ifdef OPALINE_FLOAT_LANES_H
#undef OPALINE_FLOAT_LANES_H
#else
#define OPALINE_FLOAT_LANES_H
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace opaline::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Two vectors of floats, and the few operations needed here.
struct Floats {
  using D = hn::CappedTag<float, 16>;
  using V = hn::Vec<D>;
  V a, b;

  Floats() = default;
  HWY_INLINE Floats(V first, V second) : a(first), b(second) {}
  HWY_INLINE Floats(float x) : a(hn::Set(D(), x)), b(hn::Set(D(), x)) {}  // NOLINT: formulas mix lanes and literals
};

HWY_INLINE Floats operator+(Floats x, Floats y) { return {hn::Add(x.a, y.a), hn::Add(x.b, y.b)}; }
HWY_INLINE Floats operator-(Floats x, Floats y) { return {hn::Sub(x.a, y.a), hn::Sub(x.b, y.b)}; }
HWY_INLINE Floats operator*(Floats x, Floats y) { return {hn::Mul(x.a, y.a), hn::Mul(x.b, y.b)}; }
HWY_INLINE Floats max(Floats x, Floats y) { return {hn::Max(x.a, y.a), hn::Max(x.b, y.b)}; }
HWY_INLINE Floats mul_add(Floats x, Floats y, Floats z) {
  return {hn::MulAdd(x.a, y.a, z.a), hn::MulAdd(x.b, y.b, z.b)};
}
HWY_INLINE Floats neg_mul_add(Floats x, Floats y, Floats z) {
  return {hn::NegMulAdd(x.a, y.a, z.a), hn::NegMulAdd(x.b, y.b, z.b)};
}
HWY_INLINE Floats neg_mul_sub(Floats x, Floats y, Floats z) {
  return {hn::NegMulSub(x.a, y.a, z.a), hn::NegMulSub(x.b, y.b, z.b)};
}

/// The leading 12 bits: products of two such are exact.
HWY_INLINE Floats upper_half(Floats x) {
  const Floats c = x * 4097.0f;
  return c - (c - x);
}

/// x y - p exactly, for p the rounded product.
HWY_INLINE Floats product_error(Floats x, Floats y, Floats p) {
#if HWY_NATIVE_FMA
  return {hn::MulSub(x.a, y.a, p.a), hn::MulSub(x.b, y.b, p.b)};
#else
  const Floats xh = upper_half(x), yh = upper_half(y), xl = x - xh, yl = y - yh;
  return ((xh * yh - p) + xh * yl + xl * yh) + xl * yl;
#endif
}

/// 1/sqrt(x) to 10 bits or more.
HWY_INLINE Floats::V guess_inverse_sqrt(Floats::V x) {
#if HWY_TARGET == HWY_SCALAR
  return hn::Div(hn::Set(Floats::D(), 1.0f), hn::Sqrt(x));
#else
  return hn::ApproximateReciprocalSqrt(x);
#endif
}
HWY_INLINE Floats guess_inverse_sqrt(Floats x) { return {guess_inverse_sqrt(x.a), guess_inverse_sqrt(x.b)}; }

/// p * 2^n for |n| < 126, n being the last bits of `shifted`.
HWY_INLINE Floats::V times_power(Floats::V p, Floats::V shifted) {
  const Floats::D d;
  const hn::RebindToSigned<Floats::D> di;
  return hn::BitCast(d, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, shifted))));
}

struct FloatLanes {
  Floats hi, lo;

  FloatLanes() = default;
  HWY_INLINE FloatLanes(Floats high, Floats low) : hi(high), lo(low) {}
  HWY_INLINE FloatLanes(double x)  // NOLINT: formulas mix lanes and literals
      : hi(static_cast<float>(x)), lo(static_cast<float>(x - static_cast<double>(static_cast<float>(x)))) {}
};

struct LaneMask {
  hn::Mask<Floats::D> a, b;
};

/// -x, which costs nothing inside exp.
struct NegatedLanes {
  FloatLanes of;
};
HWY_INLINE NegatedLanes operator-(const FloatLanes& x) { return {x}; }

HWY_INLINE FloatLanes operator+(const FloatLanes& x, const FloatLanes& y) {
  const Floats sum = x.hi + y.hi, of_y = sum - x.hi;
  return {sum, ((x.hi - (sum - of_y)) + (y.hi - of_y)) + (x.lo + y.lo)};
}

HWY_INLINE FloatLanes operator*(const FloatLanes& x, const FloatLanes& y) {
  const Floats product = x.hi * y.hi;
  return {product, mul_add(x.hi, y.lo, mul_add(x.lo, y.hi, product_error(x.hi, y.hi, product)))};
}

HWY_INLINE LaneMask operator<(const FloatLanes& x, double limit) {
  const Floats y(static_cast<float>(limit));
  return {hn::Lt(x.hi.a, y.a), hn::Lt(x.hi.b, y.b)};
}

HWY_INLINE Floats choose(const LaneMask& mask, Floats x, Floats y) {
  return {hn::IfThenElse(mask.a, x.a, y.a), hn::IfThenElse(mask.b, x.b, y.b)};
}
HWY_INLINE FloatLanes choose(const LaneMask& mask, const FloatLanes& x, const FloatLanes& y) {
  return {choose(mask, x.hi, y.hi), choose(mask, x.lo, y.lo)};
}

/// From the processor's guess g to second or third order in h = 1 - x g^2, which is below 1.3e-4 with AVX-512, else
/// 8e-4.
HWY_INLINE FloatLanes inverse_sqrt(const FloatLanes& x) {
  const Floats g = guess_inverse_sqrt(x.hi), h = neg_mul_add(x.hi * g, g, 1.0f);
#if HWY_TARGET <= HWY_AVX3
  const Floats factor = 0.5f;
#else
  const Floats factor = mul_add(h, 0.375f, 0.5f);
#endif
  return {mul_add(g * h, factor, g), 0.0f};
}

/// x.hi + x.lo - root^2.
HWY_INLINE Floats square_rest(const FloatLanes& x, Floats root) {
#if HWY_NATIVE_FMA
  return neg_mul_add(root, root, x.hi) + x.lo;
#else
  const Floats square = root * root;
  return ((x.hi - square) - product_error(root, root, square)) + x.lo;
#endif
}

/// sqrt(x), given 1/sqrt(x) to the last bits.
HWY_INLINE FloatLanes sqrt_by_inverse(const FloatLanes& x, const FloatLanes& inverse) {
  const Floats root = x.hi * inverse.hi;
  return {root, square_rest(x, root) * (inverse.hi * 0.5f)};
}

HWY_INLINE FloatLanes sqrt(const FloatLanes& x) {
  const FloatLanes positive(max(x.hi, 1e-37f), x.lo);
  return sqrt_by_inverse(x, inverse_sqrt(positive));
}

/// exp(-x) for x in [-87, 87].
HWY_INLINE FloatLanes exp(const NegatedLanes& negated) {
  const FloatLanes& x = negated.of;
  const Floats magic = 12582912.0f;  // 1.5 * 2^23: adding it leaves n = round(-x / ln 2) in the last bits
  const Floats shifted = neg_mul_add(x.hi, 1.44269504f, magic), n = shifted - magic;
  const Floats coarse = neg_mul_sub(n, 0.693145752f, x.hi);  // 15 bits of ln 2: exact
  const Floats r = neg_mul_add(n, 1.42860677e-6f, coarse) - x.lo;
  Floats p = 0.0013942759f;  // interpolates exp at Chebyshev nodes of |r| < 0.352, error 3e-9
  for (const float c : {0.0083764482f, 0.0416663328f, 0.1666639939f, 0.5f, 1.0f, 1.0f}) p = mul_add(p, r, c);
  return {{times_power(p.a, shifted.a), times_power(p.b, shifted.b)}, 0.0f};
}

}  // namespace opaline::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();
#endif
