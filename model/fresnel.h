// Fresnel reflection at a smooth dielectric boundary, and its exact hemispherical averages.
//
// Everything is unpolarised, dimensionless and templated on the scalar (double, ceres::Jet, a
// high-precision type). Cosines are in [0, 1]; eta > 0. Nothing here fails or allocates.
//
//   fresnel_reflectance(c, eta)      eta = n_transmitted / n_incident: what the LIGHT meets
//   diffuse_*(eta), dipole_boundary_a, exit_lobe_normalisation
//                                    eta = n_inside / n_outside of the MEDIUM (see conventions.h)
//
// Error in double: the averages, their complements and A are within 10 units in the last place for eta
// in [0.3, 3.5]; outside, down to 1e-6 and up to 1e6, the averages are within 1e-14 relative and the
// complement of a nearly total reflection within 1e-15 absolute.
//
// At eta = 1 there is no boundary: reflectance and both averages are exactly 0, at grazing incidence
// too (the limit eta -> 1 at cosine 0 is 1). The averages have a kink there; derivatives are the ones
// for eta -> 1+ (1/3 external, 7/3 internal). For eta -> 1- they are -7/3 and -1/3.
//
// Source: the Fresnel equations; averages derived below, equal to Dunkle's closed form (1963).
#pragma once

#include "model/conventions.h"

#include <cmath>

namespace opaline {

/// Fresnel reflectance for light arriving with cosine `cos_incident` at a medium of relative index
/// `eta`. 1 under total internal reflection, with zero derivative.
template <typename T>
T fresnel_reflectance(const T& cos_incident, const T& eta) {
  using std::sqrt;
  if (eta == 1.0) return T(0.0);
  // (c - s)/(c + s) and its like lose all digits near eta = 1; with c^2 - s^2 = 1 - eta^2 they don't.
  const T m = (eta - 1.0) * (eta + 1.0);
  const T s_squared = cos_incident * cos_incident + m;
  if (s_squared <= 0.0) return T(1.0);
  const T s = sqrt(s_squared);
  const T eta_squared = eta * eta;
  const T sum_s = cos_incident + s, sum_p = eta_squared * cos_incident + s;
  const T r_s = m / (sum_s * sum_s);
  const T r_p = m * ((eta_squared + 1.0) * cos_incident * cos_incident - 1.0) / (sum_p * sum_p);
  return (r_s * r_s + r_p * r_p) * 0.5;
}

/// 1 - fresnel_reflectance, without the subtraction.
template <typename T>
T fresnel_transmittance(const T& cos_incident, const T& eta) {
  using std::sqrt;
  if (eta == 1.0) return T(1.0);
  const T s_squared = cos_incident * cos_incident + (eta - 1.0) * (eta + 1.0);
  if (s_squared <= 0.0) return T(0.0);
  const T s = sqrt(s_squared);
  const T eta_squared = eta * eta;
  const T sum_s = cos_incident + s, sum_p = eta_squared * cos_incident + s;
  return 2.0 * cos_incident * s * (1.0 / (sum_s * sum_s) + eta_squared / (sum_p * sum_p));
}

// The averages. Let n = max(eta, 1/eta), a^2 = n^2 - 1, x = (n-1)/(n+1), b = (n^2-1)/(n^2+1), and let
// light arrive from the thin side. With cos = a sinh u and p = exp(-2u) both amplitudes are rational,
//   r_s = -p,   r_p = (b - p)/(1 - b p),   cos d(cos) = -(a^2/8)(1/p^2 - 1) dp,   p from x to 1,
// so E = int F 2 cos d(cos) = S + P with
//   S = (a^2/8) int (1 - p^2) dp = x (2 + x)/6,
//   P = (a^2/8) Q,  Q = int ((b - p)/(1 - b p))^2 (1 - p^2)/p^2 dp.
namespace fresnel_detail {

/// int_x^1 p^k (1 - p^2) dp for k >= 0, given x^(k+1).
template <typename T>
T power_moment(double k, const T& x, const T& x_power) {
  return (2.0 - x_power * (k + 3.0 - (k + 1.0) * x * x)) / ((k + 1.0) * (k + 3.0));
}

/// E by expanding (1 - b p)^-2 = sum (j+1) (b p)^j and integrating term by term. Every term is
/// positive, so little cancels; about 30 terms at n = 1.5, 60 at 2 and 200 at 3.5, the largest in use.
template <typename T>
T entering_series(const T& x) {
  using std::log;
  const T b = 2.0 * x / (1.0 + x * x);
  const T below = (1.0 - x) * (1.0 - x);
  // The moments k = j-2, j-1, j of term j; the first two hold the pole at p = 0.
  T b2_m2 = b * 2.0 / (1.0 + x * x) * below;  // b^2 int p^-2 (1 - p^2) dp, kept finite as x -> 0
  T m1 = -log(x) - (1.0 - x) * (1.0 + x) * 0.5;
  T m0 = power_moment(0.0, x, x);
  T x_power = x, b_power = T(1.0), q = T(0.0);
  for (double j = 0.0;; ++j) {
    const T term = (j + 1.0) * b_power * (b2_m2 - 2.0 * b * m1 + m0);
    q += term;
    // The factor covers the rest of the series and its derivative, should T carry one.
    if (q + (j + 2.0) * 16.0 * term == q) break;
    x_power *= x;
    b_power *= b;
    b2_m2 = b * b * m1;
    m1 = m0;
    m0 = power_moment(j + 1.0, x, x_power);
  }
  return x * (2.0 + x) / 6.0 + x / (2.0 * below) * q;
}

/// E in closed form (partial fractions of Q), v = 1/n. Its terms cancel as x -> 0.
template <typename T>
T entering_closed(const T& x, const T& v) {
  using std::log;
  const T v2 = v * v, v4 = v2 * v2;
  const T s = 1.0 + v2, d = (1.0 - v) * (1.0 + v), d4 = d * s;
  const T rational =
      0.5 + (1.0 - v) * (3.0 + v) / (6.0 * (1.0 + v) * (1.0 + v)) - 2.0 * v * (1.0 + 2.0 * v - v2) / (s * d4);
  const T logs = d * d * log(x) / (s * s * s) - 8.0 * v2 * (1.0 + v4) * log(v) / (s * d4 * d4);
  return rational + logs;
}

/// x without the rounding of 1/eta.
template <typename T>
T contrast(const T& eta) {
  return eta >= 1.0 ? T((eta - 1.0) / (eta + 1.0)) : T((1.0 - eta) / (1.0 + eta));
}

/// 1/n.
template <typename T>
T inverse_index(const T& eta) {
  return eta >= 1.0 ? T(1.0 / eta) : eta;
}

/// E: mean reflectance for diffuse light arriving from the thin side.
template <typename T>
T entering_reflectance(const T& eta) {
  const T x = contrast(eta);
  if (x == 0.0) return x * (2.0 / 3.0);        // the leading term, for its derivative
  if (x < 0.56) return T(entering_series(x));  // n < 3.55
  return T(entering_closed(x, inverse_index(eta)));
}

/// Mean reflectance from the dense side, (a^2 + E)/n^2: all beyond the critical angle, plus E by
/// reciprocity.
template <typename T>
T leaving_reflectance(const T& eta) {
  const T x = contrast(eta), v = inverse_index(eta);
  return 4.0 * x / ((1.0 + x) * (1.0 + x)) + v * v * entering_reflectance(eta);
}

}  // namespace fresnel_detail

/// Mean reflectance of diffuse light from OUTSIDE: 2 int_0^1 F(c, eta) c dc = 2 C_1(1/eta).
template <typename T>
T diffuse_reflectance_external(const T& eta) {
  using namespace fresnel_detail;
  return eta >= 1.0 ? T(entering_reflectance(eta)) : T(leaving_reflectance(eta));
}

/// Mean reflectance of diffuse light from INSIDE: F_dr = 2 int_0^1 F(c, 1/eta) c dc = 2 C_1(eta).
template <typename T>
T diffuse_reflectance_internal(const T& eta) {
  using namespace fresnel_detail;
  return eta >= 1.0 ? T(leaving_reflectance(eta)) : T(entering_reflectance(eta));
}

/// 1 - diffuse_reflectance_external(eta), in (0, 1].
template <typename T>
T diffuse_transmittance_external(const T& eta) {
  const T through = 1.0 - fresnel_detail::entering_reflectance(eta);
  return eta >= 1.0 ? through : T(eta * eta * through);
}

/// 1 - diffuse_reflectance_internal(eta), in (0, 1]; the external one divided by eta^2.
template <typename T>
T diffuse_transmittance_internal(const T& eta) {
  const T through = 1.0 - fresnel_detail::entering_reflectance(eta);
  return eta >= 1.0 ? T(through / (eta * eta)) : through;
}

/// A = (1 + F_dr)/(1 - F_dr) of the dipole's extrapolated boundary z_b = 2 A D; 1 at eta = 1.
template <typename T>
T dipole_boundary_a(const T& eta) {
  return (1.0 + diffuse_reflectance_internal(eta)) / diffuse_transmittance_internal(eta);
}

/// c of L_o = F_t(eta, w_o) B/(pi c): the cosine-weighted mean of F_t outside (`normalised`), or 1.
template <typename T>
T exit_lobe_normalisation(const T& eta, ExitLobe lobe) {
  return lobe == ExitLobe::normalised ? diffuse_transmittance_external(eta) : T(1.0);
}

}  // namespace opaline
