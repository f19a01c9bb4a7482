// One pole of a diffusion dipole: a point source at depth z [mm] in a medium with effective
// transport coefficient sigma [1/mm] (sigma_tr, or 0). Its share of the surface flux, its integral
// over a disk, and exact sampling by distance. A dipole is a sum of two.
//
//   P(r) = z (1 + sigma d) exp(-sigma d) / (2 pi d^3),  d^2 = r^2 + z^2     [1/mm^2]
//   2 pi int_0^inf P r dr = exp(-sigma z)
//
// Templated on the scalar. z in [1e-90, 1e90] mm, sigma in [0, 1e90] 1/mm, r in [0, 1e150] mm.
// Source: Jensen et al. 2001 for P; Mertens et al. 2003 for sampling by solving for the distance.
#pragma once

#include "model/conventions.h"

#include <algorithm>
#include <cmath>

namespace opaline {

/// (1 + y) exp(-y) with y = sqrt(t), t >= 0. Smooth in t to first order (derivative -exp(-y)/2), but
/// the derivative of sqrt is infinite at 0: a dual number (ceres::Jet: value `a`, gradient `v`) gets
/// the closed form, so that gradients stay exact down to sigma_a = 0. 0 beyond y = 1e4.
template <typename T>
T screening(const T& t) {
  using std::exp;
  using std::sqrt;
  if constexpr (requires {
                  t.a;
                  t.v;
                }) {
    const auto y = sqrt(t.a);
    return y < 1e4 ? T(screening(t.a), t.v * (-0.5 * exp(-y))) : T(0.0);
  } else {
    const T y = sqrt(t);
    return y < 1e4 ? T((1.0 + y) * exp(-y)) : T(0.0);
  }
}

/// P as a function of q = r^2 and sigma^2: no square root of an argument, so smooth in both.
template <typename T>
T pole_evaluate_squared(const T& q, const T& z, const T& sigma_squared) {
  using std::sqrt;
  const T d_squared = q + z * z;
  // In this order neither d^3 nor its derivatives overflow.
  return screening(T(sigma_squared * d_squared)) * (z / sqrt(d_squared)) / (2.0 * pi * d_squared);
}

/// 2 pi int_0^r P s ds = exp(-sigma z) - (z/d) exp(-sigma d), written with h = d - z so that every
/// term is positive: full relative accuracy down to r = 0.
template <typename T>
T pole_cumulative(const T& r, const T& z, const T& sigma) {
  using std::exp;
  using std::expm1;
  using std::sqrt;
  const T d = sqrt(r * r + z * z);
  const T h = r * (r / (d + z));
  return exp(-sigma * z) * (h - z * expm1(-sigma * h)) / d;
}

/// A distance and the steps its solve took.
struct PoleSample {
  double r;
  int steps;
};

/// As sample_pole.
inline PoleSample sample_pole_counted(double z, double sigma, double xi) {
  const double target = -std::log1p(-xi);
  if (!(target > 0)) return {0, 0};
  // In v = log(1 + w) the equation f = c expm1(v) + v - target = 0 is increasing and convex, f'' = f' - 1, and both
  // bounds below lie right of the root: Halley's method takes two or three steps and keeps full relative accuracy for
  // small xi (w ~ v) and for large.
  const double c = sigma * z;
  double v = target / (1 + c), w = 0, step = 0;
  if (v > 0.5) v = std::min(v, std::log1p(target / c));
  int steps = 0;
  while (steps < 8) {
    w = std::expm1(v);
    const double slope = c * w + c + 1, newton = (c * w + (v - target)) / slope;
    step = newton / (1 - 0.5 * newton * ((slope - 1) / slope));
    v -= step;
    ++steps;
    if (std::abs(step) <= 2e-6 * std::min(v, 1.0)) break;  // cubic: the next step is below the rounding
  }
  w -= (1 + w) * step * (1 - step * (0.5 - step / 6));  // expm1 of the last step
  return {z * std::sqrt(w * (w + 2)), steps};
}

/// The distance r with pole_cumulative(r) = xi exp(-sigma z), xi in [0, 1): solve
/// sigma z w + log(1 + w) = -log(1 - xi) for w = d/z - 1 >= 0, in at most 8 steps. Relative error below 1e-14 for xi up
/// to 1 - 2^-53 and sigma z from 0 to 1e300, as long as xi/(1 + sigma z) > 1e-300.
inline double sample_pole(double z, double sigma, double xi) { return sample_pole_counted(z, sigma, xi).r; }

/// Sampling of the sum of two poles at depths z_near <= z_far: one of them, chosen by its share of the flux,
/// reusing xi. (Not the inverse of the summed cumulative: the result isn't monotone in xi.)
inline double near_pole_share(double z_near, double z_far, double sigma) {
  return 1 / (1 + std::exp(-sigma * (z_far - z_near)));
}
inline double sample_pole_pair(double z_near, double z_far, double sigma, double share, double xi) {
  constexpr double below_one = 1 - 0x1p-53;
  if (xi < share) return sample_pole(z_near, sigma, std::min(xi / share, below_one));
  return sample_pole(z_far, sigma, std::min((xi - share) / (1 - share), below_one));
}
inline double sample_pole_pair(double z_near, double z_far, double sigma, double xi) {
  return sample_pole_pair(z_near, z_far, sigma, near_pole_share(z_near, z_far, sigma), xi);
}

}  // namespace opaline
