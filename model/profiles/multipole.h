// The multipole of a slab (Donner & Jensen 2005): a normal beam's source one transport mean free path deep and its
// images in the two extrapolated boundaries; diffuse reflectance R(r) and transmittance T(r).
//
//   R(r) = (alpha'/2) sum_i [ P(r; z_r,i) - P(r; z_v,i) ],  T(r) = (alpha'/2) sum_i [ P(r; d - z_r,i) - P(r; d - z_v,i)
//   ] z_r,i = 2 i L + l,  z_v,i = 2 i L - l - 2 z_b0,  L = d + z_b0 + z_bd,  z_b = 2 A D,  D = 1/(3 sigma_t')
//
// with P of poles.h taken as odd in z, l = 1/sigma_t', and A of fresnel.h at either side. The boundary is the
// standard dipole's, which R becomes for d -> infinity.
//
// The images converge for r < L/2, where the ones beyond the 24th are added up by the Euler-Maclaurin formula; from
// there on the slab's modes do (Poisson's sum of the images),
//   R(r) = alpha'/(pi L) sum_n k_n cos(k_n z_b0) sin(k_n (l + z_b0)) K_0(beta_n r),  k_n = n pi/L, beta_n^2 = s^2 +
//   k_n^2,
// and T likewise with -cos(k_n (d + z_b0)). Relative error 1e-8 for r up to 200 L. Closed totals: derived here.
//
// Units and normalisation: conventions.h. Needs d > l, the source inside (see multipole_applies); near that the
// model is poor: at d = 2 l it says R = T. sigma_t' and d in [1e-60, 1e60]. s = 0 is no exception; dual numbers as in
// standard_dipole.h.
#pragma once

#include "model/fresnel.h"
#include "model/profiles/poles.h"
#include "model/profiles/yukawa.h"

#include <array>

namespace opaline {

/// A homogeneous slab: the medium with its upper boundary's eta, thickness [mm], eta at the lower boundary.
template <typename T>
struct Slab {
  Medium<T> medium;
  T thickness{};
  T eta_below{1};
};

/// Whether the source lies inside the slab.
inline bool multipole_applies(const Slab<double>& slab) {
  return slab.thickness * (slab.medium.sigma_a + slab.medium.sigma_s_prime) > 1;
}

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

template <typename T>
struct Multipole {
  static constexpr int images = 24, modes = 32;

  T alpha_prime;       ///< reduced albedo, 0 .. 1
  T sigma_tr_squared;  ///< [1/mm^2]
  T sigma_tr;          ///< [1/mm]
  T depth, thickness;  ///< l and d [mm]
  T z_b0, z_bd;        ///< extrapolation at the top and at the bottom [mm]
  T period;            ///< L [mm]

  explicit Multipole(const Slab<T>& slab) {
    using std::sqrt;
    const Medium<T>& m = slab.medium;
    const T sigma_t_prime = m.sigma_a + m.sigma_s_prime;
    alpha_prime = m.sigma_s_prime / sigma_t_prime;
    sigma_tr_squared = 3.0 * m.sigma_a * sigma_t_prime;
    sigma_tr = sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(sigma_tr_squared));
    depth = 1.0 / sigma_t_prime;
    thickness = slab.thickness;
    z_b0 = 2.0 / 3.0 * depth * dipole_boundary_a(m.eta);
    z_bd = 2.0 / 3.0 * depth * dipole_boundary_a(slab.eta_below);
    period = thickness + z_b0 + z_bd;
  }

  /// R [1/mm^2] at distance r [mm] from the beam on its side, T on the other.
  T reflectance(const T& r) const {
    if (r < 0.5 * period) return 0.5 * alpha_prime * image_sum(T(r * r), T(0.0), 1);
    return alpha_prime / (pi * period) * mode_sum(r, z_b0, 1);
  }
  T transmittance(const T& r) const {
    if (r < 0.5 * period) return 0.5 * alpha_prime * image_sum(T(r * r), thickness, -1);
    return alpha_prime / (pi * period) * mode_sum(r, T(thickness + z_b0), -1);
  }

  /// 2 pi int_0^inf R r dr = alpha' cosh(s z_b0) sinh(s (d + z_bd - l))/sinh(s L), and that of T.
  T total_reflectance() const { return alpha_prime * share(z_b0, T(thickness + z_bd - depth), depth); }
  T total_transmittance() const { return alpha_prime * share(z_bd, T(depth + z_b0), T(thickness - depth)); }

 private:
  /// cosh(s a) sinh(s b)/sinh(s L) with L = a + b + rest: no overflow, b/L at s = 0.
  T share(const T& a, const T& b, const T& rest) const {
    using std::exp;
    const T s = sigma_tr, b_decay = b * mean_decay(T(2.0 * s * b));
    return exp(-s * rest) * 0.5 * (1.0 + exp(-2.0 * s * a)) * b_decay / (period * mean_decay(T(2.0 * s * period)));
  }

  /// Images on one side (way = 1: away from the beam, -1) beyond the last, by int P dz = -exp(-s d)/(2 pi d).
  T tail(const T& q, const T& z_next, double way) const {
    using std::exp;
    using std::sqrt;
    const T step = 2.0 * period, z = z_next - way * 0.5 * step;  // half a step before the first left out
    const T d = sqrt(q + z * z);
    const T slope = pole(q, z_next) - pole(q, T(z_next - way * step));
    return way * exp(-sigma_tr * d) / (2.0 * pi * d * step) + slope / 24.0;
  }

  T pole(const T& q, const T& z) const { return pole_evaluate_squared(q, z, sigma_tr_squared); }

  /// sum_i P(sign (z_r,i - origin)) - P(sign (z_v,i - origin)): the images seen from z = origin.
  T image_sum(const T& q, const T& origin, double sign) const {
    const T real = depth - origin, image = -depth - 2.0 * z_b0 - origin, step = 2.0 * period;
    T sum = pole(q, real) - pole(q, image);
    for (int i = 1; i <= images; ++i) {
      const T shift = static_cast<double>(i) * step;
      sum += pole(q, T(real + shift)) - pole(q, T(image + shift));
      sum += pole(q, T(real - shift)) - pole(q, T(image - shift));
    }
    const T next = (images + 1.0) * step;
    sum += tail(q, T(real + next), 1) - tail(q, T(image + next), 1);
    sum += tail(q, T(real - next), -1) - tail(q, T(image - next), -1);
    return sign * sum;
  }

  /// sum_n k_n sign cos(k_n height) sin(k_n (l + z_b0)) K_0(beta_n r), height above the upper extrapolated boundary.
  T mode_sum(const T& r, const T& height, double sign) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    T sum = T(0.0);
    for (int n = 1; n <= modes; ++n) {
      const T k = n * pi / period;
      sum += k * cos(k * height) * sin(k * (depth + z_b0)) * bessel_k0(T(r * sqrt(sigma_tr_squared + k * k)));
    }
    return sign * sum;
  }
};

}  // namespace opaline
