// The quadrature rules that more than one formula uses, templated on the scalar (double, ceres::Jet, ...).
// Nodes and weights are doubles: a wider type gets 1e-16.
#pragma once

#include <cmath>

namespace opaline {

/// int_a^b f by the 16-point Gauss-Legendre rule: exact for polynomials up to degree 31.
template <typename T, typename F>
T gauss_legendre(const T& a, const T& b, const F& f) {
  static constexpr double node[] = {0.0950125098376374402, 0.2816035507792589132, 0.4580167776572273863,
                                    0.6178762444026437484, 0.7554044083550030339, 0.8656312023878317439,
                                    0.9445750230732325761, 0.9894009349916499326};
  static constexpr double weight[] = {0.1894506104550684963, 0.1826034150449235889, 0.1691565193950025382,
                                      0.1495959888165767321, 0.1246289712555338721, 0.0951585116824927848,
                                      0.0622535239386478929, 0.0271524594117540949};
  const T centre = 0.5 * (a + b), half = 0.5 * (b - a);
  T sum = T(0.0);
  for (int i = 0; i < 8; ++i) sum += weight[i] * (f(T(centre - half * node[i])) + f(T(centre + half * node[i])));
  return half * sum;
}

/// int_0^inf f(w) dw by the double-exponential rule w = exp(pi/2 sinh k), w from 2e-19 to 4e18: for f analytic in
/// w > 0 that falls like w^-2 or faster, with any power >= 0 at w = 0. Relative error about 1e-12.
template <typename T, typename F>
T integrate_half_line(const F& f) {
  constexpr double step = 0.0625, half_pi = 1.57079632679489662;
  T sum = T(0.0);
  for (int i = -64; i <= 64; ++i) {
    const double k = i * step, w = std::exp(half_pi * std::sinh(k));
    sum += step * half_pi * std::cosh(k) * w * f(w);
  }
  return sum;
}

}  // namespace opaline
