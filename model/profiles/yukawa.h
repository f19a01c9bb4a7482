// The fluence part of a dipole: the difference of the Yukawa potentials of a source at depth z_r [mm] and an
// image at height z_v > z_r in a medium with effective transport coefficient s [1/mm] (sigma_tr, or 0).
//
//   G(r) = ( exp(-s d_r)/d_r - exp(-s d_v)/d_v ) / (2 pi (z_v - z_r)),  d^2 = r^2 + z^2     [1/mm^2]
//   2 pi int_0^inf G r dr = exp(-s z_r) phi(s (z_v - z_r)),  phi(x) = (1 - exp(-x))/x
//
// Templated on the scalar; every difference is taken without cancellation, and s = 0 is no exception.
// Source: d'Eon 2012 (better dipole), in this normalisation: derived here.
#pragma once

#include "model/conventions.h"

#include <cmath>

namespace opaline {

/// (1 - exp(-x))/x, 1 at 0. (A dual number at x = 0 gets no derivative: it is lost in sqrt there anyway.)
template <typename T>
T mean_decay(const T& x) {
  using std::expm1;
  return x == 0.0 ? T(1.0) : T(-expm1(-x) / x);
}

/// G as a function of q = r^2 and s^2. Like `screening` (poles.h), its derivative by s^2 is finite at s = 0, and a dual
/// number (ceres::Jet) gets it in closed form.
template <typename T>
T yukawa_gap_squared(const T& q, const T& z_r, const T& z_v, const T& s_squared) {
  using std::exp;
  using std::expm1;
  using std::sqrt;
  const T d_r = sqrt(q + z_r * z_r), d_v = sqrt(q + z_v * z_v);
  const T rise = (z_v + z_r) / (d_v + d_r);  // (d_v - d_r)/(z_v - z_r)
  const auto gap = [&](const T& s) {
    const T h = (z_v - z_r) * rise;
    return T(exp(-s * d_r) / d_v * (rise / d_r + s * rise * mean_decay(T(s * h))) / (2.0 * pi));
  };
  if constexpr (requires {
                  s_squared.a;
                  s_squared.v;
                }) {
    using Scalar = decltype(s_squared.a);
    const Scalar s = sqrt(s_squared.a), h = ((z_v - z_r) * rise).a;
    const Scalar slope = -exp(-s * d_r.a) * rise.a * mean_decay(Scalar(s * h)) / (4.0 * pi);
    return gap(T(s)) + T(Scalar(0.0), s_squared.v * slope);
  } else {
    return gap(T(sqrt(s_squared)));
  }
}

/// 2 pi int_0^inf G r dr.
template <typename T>
T yukawa_gap_total(const T& z_r, const T& z_v, const T& s) {
  using std::exp;
  return exp(-s * z_r) * mean_decay(T(s * (z_v - z_r)));
}

/// 2 pi int_0^r G t dt: near the axis the integrals of exp(-s t) over [z, d] for both, far from it the whole less
/// the one over [d_r, d_v].
template <typename T>
T yukawa_gap_cumulative(const T& r, const T& z_r, const T& z_v, const T& s) {
  using std::exp;
  using std::sqrt;
  const T d_r = sqrt(r * r + z_r * z_r), d_v = sqrt(r * r + z_v * z_v);
  const T h_r = r * (r / (d_r + z_r)), h_v = r * (r / (d_v + z_v));
  if (r < z_v) {
    const T near = h_r * exp(-s * z_r) * mean_decay(T(s * h_r)), far = h_v * exp(-s * z_v) * mean_decay(T(s * h_v));
    return (near - far) / (z_v - z_r);
  }
  const T rise = (z_v + z_r) / (d_v + d_r);
  return yukawa_gap_total(z_r, z_v, s) - rise * exp(-s * d_r) * mean_decay(T(s * (z_v - z_r) * rise));
}

/// int G J_0(k r) 2 pi r dr with d^2 = r^2 + z^2 + x^2: the 2-D spectrum at k [1/mm] of what G sends to a plane x [mm]
/// from its own. A Yukawa potential exp(-s d)/d has 2 pi exp(-beta h)/beta, beta^2 = s^2 + k^2, h^2 = z^2 + x^2.
template <typename T>
T yukawa_gap_spectrum(const T& k, const T& x, const T& z_r, const T& z_v, const T& s) {
  using std::exp;
  using std::sqrt;
  const T beta = sqrt(s * s + k * k), h_r = sqrt(z_r * z_r + x * x), h_v = sqrt(z_v * z_v + x * x);
  const T rise = (z_v + z_r) / (h_v + h_r);  // (h_v - h_r)/(z_v - z_r)
  return rise * exp(-beta * h_r) * mean_decay(T(beta * (z_v - z_r) * rise));
}

}  // namespace opaline
