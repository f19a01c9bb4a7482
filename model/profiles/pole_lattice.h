// A pole between two absorbing planes and all its mirror images:
//
//   Q(y) = sum_i P(y + 2 i L), i over all integers, P of poles.h taken as odd in its depth
//
// for a pole at distance y from the one plane and L - y from the other: odd in y, of period 2 L, 0 on both planes. The
// multipole is two of them. Every difference of images is taken without cancellation, so Q keeps its digits when the
// pole lies close to a plane.
//
// The images converge for r < max(L/2, s L^2), where those beyond the 16th are summed by the Euler-Maclaurin formula;
// from there on the modes between the planes do (Poisson's sum of the images):
//
//   Q(y) = 1/(pi L) sum_n k_n sin(k_n y) K_0(beta_n r),  k_n = n pi/L,  beta_n^2 = s^2 + k_n^2
//
// Relative error 1e-10 for r up to 200 L. Templated on the scalar; derived here.
#pragma once

#include "model/profiles/poles.h"
#include "model/profiles/yukawa.h"

namespace opaline {

/// K_0(x), relative error 1e-14 for x >= 1: with 2 sinh(t/2) = v/sqrt(x) in int exp(-x cosh t) dt it is
/// exp(-x) int_0^inf exp(-v^2/2)/sqrt(x + v^2/4) dv, by the trapezoid rule.
template <typename T>
T bessel_k0(const T& x) {
  using std::exp;
  using std::sqrt;
  constexpr double step = 0.35;
  T sum = 0.5 / sqrt(x);
  for (double v = step; v < 9; v += step) sum += std::exp(-0.5 * v * v) / sqrt(x + 0.25 * v * v);
  return step * exp(-x) * sum;
}

/// screening at d_far less screening at d_near, without cancellation; d_far - d_near = gap > 0.
template <typename T>
T screening_difference(const T& s_squared, const T& d_near, const T& d_far, const T& gap) {
  using std::exp;
  using std::expm1;
  using std::sqrt;
  const auto difference = [&](const T& s) {
    const T x = s * gap, decay = exp(-s * d_near);
    return T(decay * ((1.0 + s * d_near) * expm1(-x) + x * exp(-x)));
  };
  if constexpr (requires {
                  s_squared.a;
                  s_squared.v;
                }) {  // by s^2 in closed form: finite at 0, see `screening`
    using Scalar = decltype(s_squared.a);
    const Scalar s = sqrt(s_squared.a), near = d_near.a, wide = gap.a, x = s * wide;
    const Scalar slope = -0.5 * exp(-s * near) * (wide * (near + d_far.a) * exp(-x) + near * near * expm1(-x));
    return difference(T(s)) + T(Scalar(0.0), s_squared.v * slope);
  } else {
    return difference(T(sqrt(s_squared)));
  }
}

/// P(a + h) - P(a - h) for a > |h|, q = r^2.
template <typename T>
T pole_difference(const T& q, const T& a, const T& h, const T& s_squared) {
  using std::sqrt;
  const T high = a + h, low = a - h, d_high = sqrt(q + high * high), d_low = sqrt(q + low * low);
  const T gap = 4.0 * a * h / (d_high + d_low);  // d_high - d_low
  const T s_high = screening(T(s_squared * d_high * d_high)), s_low = screening(T(s_squared * d_low * d_low));
  const T cube_high = d_high * d_high * d_high, cube_low = d_low * d_low * d_low;
  const T rise = h < 0.0 ? T(-screening_difference(s_squared, d_high, d_low, T(-gap)))
                         : screening_difference(s_squared, d_low, d_high, gap);
  const T cubes = -gap * (d_high * d_high + d_high * d_low + d_low * d_low) / (cube_high * cube_low);
  return (h * (s_high / cube_high + s_low / cube_low) + a * (rise / cube_high + s_low * cubes)) / (2.0 * pi);
}

template <typename T>
struct PoleLattice {
  static constexpr int images = 16, modes = 24;

  T period;            ///< L [mm]
  T sigma_tr_squared;  ///< [1/mm^2]

  /// Q [1/mm^2] at r [mm] of a pole at `start` from the one plane and `end` from the other, start + end = L.
  /// One of them may be negative: behind a plane.
  T evaluate(const T& r, const T& start, const T& end) const {
    const T q = sum(r, start, end);
    return q < 0.0 && start > 0.0 && end > 0.0 ? T(0.0) : q;  // below 1e-300, where digits are lost
  }

 private:
  T sum(const T& r, const T& start, const T& end) const {
    if (r < 0.5 * period || r * r < sigma_tr_squared * period * period * period * period) {
      const T q = r * r;
      if (start < end) return pole(q, start) + image_pairs(q, T(2.0 * period), start);
      return -image_pairs(q, period, end);
    }
    return start < end ? mode_sum(r, start, 1) : mode_sum(r, end, -1);
  }

  T pole(const T& q, const T& z) const { return pole_evaluate_squared(q, z, sigma_tr_squared); }
  T pair(const T& q, const T& a, const T& h) const { return pole_difference(q, a, h, sigma_tr_squared); }

  /// sum_i P(a_i + h) - P(a_i - h), a_i = first + 2 i L, i >= 0.
  T image_pairs(const T& q, const T& first, const T& h) const {
    const T step = 2.0 * period;
    T all = T(0.0), last = T(0.0), before = T(0.0);
    for (int i = 0; i < images; ++i) {
      before = last;
      last = pair(q, T(first + static_cast<double>(i) * step), h);
      all += last;
    }
    // The rest by the integral from half a step before the next pair, with the odd derivatives there.
    const T next_at = first + static_cast<double>(images) * step, middle = next_at - 0.5 * step;
    const T next = pair(q, next_at, h), after = pair(q, T(next_at + step), h);
    const T slope = (27.0 * (next - last) - (after - before)) / 24.0, third = after - before - 3.0 * (next - last);
    const T integral = -2.0 * h / step * yukawa_gap_squared(q, T(middle - h), T(middle + h), sigma_tr_squared);
    return all + integral + slope / 24.0 - 7.0 / 5760.0 * third;
  }

  /// sum_n k_n sin(k_n y) K_0(beta_n r); with sign -1 of L - y.
  T mode_sum(const T& r, const T& y, double sign) const {
    using std::sin;
    using std::sqrt;
    T all = T(0.0);
    double alternating = 1;
    for (int n = 1; n <= modes; ++n) {
      const T k = n * pi / period;
      all += alternating * k * sin(k * y) * bessel_k0(T(r * sqrt(sigma_tr_squared + k * k)));
      alternating *= sign;
    }
    return all / (pi * period);
  }
};

}  // namespace opaline
