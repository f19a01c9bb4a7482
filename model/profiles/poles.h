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

/// exp(-y) counts as 0 beyond.
template <typename T>
constexpr double largest_exponent = 1e4;

template <typename T>
T choose(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}

template <typename T>
T inverse_sqrt(const T& x) {
  using std::sqrt;
  return 1.0 / sqrt(x);
}

template <typename T>
T screening_of_product(const T& a, const T& b, const T& inverse_root_of_b);

#include "model/profiles/pole_formula.h"

/// screening_at(y) with y = sqrt(t), t >= 0. Smooth in t to first order (derivative -exp(-y)/2), but
/// the derivative of sqrt is infinite at 0: a dual number (ceres::Jet: value `a`, gradient `v`) gets
/// the closed form, so that gradients stay exact down to sigma_a = 0.
template <typename T>
T screening(const T& t) {
  using std::exp;
  using std::sqrt;
  if constexpr (requires {
                  t.a;
                  t.v;
                }) {
    const auto y = sqrt(t.a);
    return y < largest_exponent<T> ? T(screening(t.a), t.v * (-0.5 * exp(-y))) : T(0.0);
  } else {
    return screening_at(T(sqrt(t)));
  }
}

/// screening(a b). Vector lanes have a shorter way, by the last argument.
template <typename T>
T screening_of_product(const T& a, const T& b, const T&) {
  return screening(T(a * b));
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

/// int P(r) J_0(k r) 2 pi r dr with d^2 = r^2 + z^2 + x^2: the 2-D spectrum, at k [1/mm], of what the pole sends to a
/// plane x [mm] from its own surface. z exp(-beta h)/h with beta^2 = sigma^2 + k^2 and h^2 = z^2 + x^2.
template <typename T>
T pole_spectrum(const T& k, const T& x, const T& z, const T& sigma) {
  using std::exp;
  using std::sqrt;
  const T h = sqrt(z * z + x * x);
  return z / h * exp(-sqrt(sigma * sigma + k * k) * h);
}

/// The distance r with pole_cumulative(r) = xi exp(-sigma z), xi in [0, 1): solve
/// sigma z w + log(1 + w) = -log(1 - xi) for w = d/z - 1 >= 0. Relative error below 1e-14 for xi up
/// to 1 - 2^-53 and sigma z from 0 to 1e300, as long as xi/(1 + sigma z) > 1e-300. At most 8 steps, which are added to
/// *steps.
inline double sample_pole(double z, double sigma, double xi, int* steps = nullptr) {
  const double target = -std::log1p(-xi);
  if (!(target > 0)) return 0;
  // In v = log(1 + w) the function f = c expm1(v) + v - target is increasing and convex, and both starts lie right of
  // its root; full relative accuracy is kept for small xi (w ~ v) and for large. Householder's method of fourth order:
  // one expm1 gives all derivatives, as the second and third are the first less 1.
  const double c = sigma * z;
  double v = target / (1 + c), w = 0;
  if (v > 1) v = std::min(v, std::log1p(target / c));
  for (int i = 0; i < 8; ++i) {
    w = std::expm1(v);
    const double inverse_slope = 1 / (c * w + c + 1);
    const double a = (c * w + (v - target)) * inverse_slope, ab = a * (1 - inverse_slope);
    const double step = a * (6 - 3 * ab) / (6 - ab * (6 - a));
    v -= step;
    w -= (1 + w) * step * (1 - step * (0.5 - step * (1.0 / 6 - step * (1.0 / 24))));  // expm1(v), if the step is small
    if (steps) ++*steps;
    if (std::abs(step) <= 2e-4 * std::min(v, 1.0)) break;  // the next one would be below the rounding
  }
  return z * std::sqrt(w * (w + 2));
}

/// The share of the flux that the nearer of two poles has.
inline double near_pole_share(double z_near, double z_far, double sigma) {
  return 1 / (1 + std::exp(-sigma * (z_far - z_near)));
}

/// Sampling of the sum of two poles at depths z_near <= z_far: one of them, chosen by its share of the flux
/// (near_pole_share), reusing xi. (Not the inverse of the summed cumulative: the result isn't monotone in xi.)
inline double sample_pole_pair(double z_near, double z_far, double sigma, double share, double xi,
                               int* steps = nullptr) {
  constexpr double below_one = 1 - 0x1p-53;
  if (xi < share) return sample_pole(z_near, sigma, std::min(xi / share, below_one), steps);
  return sample_pole(z_far, sigma, std::min((xi - share) / (1 - share), below_one), steps);
}
inline double sample_pole_pair(double z_near, double z_far, double sigma, double xi) {
  return sample_pole_pair(z_near, z_far, sigma, near_pole_share(z_near, z_far, sigma), xi);
}

}  // namespace opaline
