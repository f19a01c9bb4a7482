// Second moments of the Fresnel reflectance over the hemisphere, exactly, and what diffusion theory builds on
// them: the exitance weights C_phi, C_E and the modified boundary constant A.
//
// Conventions of fresnel.h: dimensionless, templated on the scalar, eta = n_inside / n_outside of the MEDIUM.
// Error in double: 60 units in the last place for eta in [0.3, 3.5], 1e-12 relative for eta from 1e-6 to
// 1e6. In a wider type exact for n = max(eta, 1/eta) < 3.5, and limited to 1e-16 beyond.
// At eta = 1 the moments are 0; they start like |eta - 1|^(3/2), so their derivative there is 0.
//
// Source: moments derived below; their use at the boundary: d'Eon & Irving 2011, d'Eon 2012. The papers'
// polynomials for 3 C_2 don't vanish at eta = 1 and are off by 1 % at 1.3.
#pragma once

#include "model/fresnel.h"
#include "model/quadrature.h"

namespace opaline {

// Notation of fresnel.h: n, a, x, b, cos = a sinh u from the thin side, s = a cosh u, and s/n is the cosine on the
// dense side. In q = exp(-u), p = q^2, the measures c^2 dc and (s/n)^2 d(s/n) are
//   (a^3/8) (1-p)^2 (1+p)/p^2 dq   and   ((a/n)^3/8) (1+p)^2 (1-p)/p^2 dq,   q from sqrt(x) to 1,
// so that with the weight N = 1 -+ p - p^2 +- p^3 (thin: upper signs) both need
//   W = int F N/p^2 dq = (1/2) int N dq + (1/2) int ((b - p)/(1 - b p))^2 N/p^2 dq.
namespace fresnel_detail {

enum class Side { thin, dense };

/// int_q^1 p^k N dq for k >= 0; K = 2k + 1, q_power = q^K.
template <typename T>
T second_power_moment(Side side, double K, const T& x, const T& q_power) {
  const double sign = side == Side::thin ? 1 : -1;
  const double whole = side == Side::thin ? 16 * (K + 3) : 8 * (K * (K + 6) + 6);
  const T one(1.0), below = one / K - x * (sign * one / (K + 2) + x * (one / (K + 4) - x * (sign * one / (K + 6))));
  return whole * one / (K * (K + 2) * (K + 4) * (K + 6)) - q_power * below;
}

/// The moments k = -2 (times b^2), -1 and 0, factored at q = 1 where they cancel.
template <typename T>
struct SecondMoments {
  T b2_m2, m1, m0;

  SecondMoments(Side side, const T& q, const T& x) {
    const T d = 1.0 - q, d2 = d * d, pole = 4.0 * q / (3.0 * (1.0 + x * x) * (1.0 + x * x)), w = 1.0 + x;
    if (side == Side::thin) {
      b2_m2 = pole * (1.0 - x) * (1.0 - x) * (1.0 - x);
      m1 = d * d2 * (15.0 + q * (13.0 + q * (9.0 + q * 3.0))) / (15.0 * q);
      m0 = d * d2 * (64.0 + q * (87.0 + q * (69.0 + q * (45.0 + q * 15.0)))) / 105.0;
    } else {
      b2_m2 = pole * d2 * (w * w + 2.0 * q * w + 4.0 * x);
      m1 = d2 * (15.0 + q * (22.0 + q * (14.0 + q * (6.0 + q * 3.0)))) / (15.0 * q);
      m0 = d2 * (104.0 + q * (103.0 + q * (102.0 + q * (66.0 + q * (30.0 + q * 15.0))))) / 105.0;
    }
  }
};

/// W by the expansion used in entering_series, n < 3.55.
template <typename T>
T second_series(Side side, const T& x) {
  using std::sqrt;
  const T q = sqrt(x), b = 2.0 * x / (1.0 + x * x);
  SecondMoments<T> m(side, q, x);
  T q_power = q, b_power = T(1.0), sum = m.m0;
  for (double j = 0.0;; ++j) {
    const T term = (j + 1.0) * b_power * (m.b2_m2 - 2.0 * b * m.m1 + m.m0);
    sum += term;
    if (sum + (j + 2.0) * 16.0 * term == sum) break;
    q_power *= x;
    b_power *= b;
    m.b2_m2 = b * b * m.m1;
    m.m1 = m.m0;
    m.m0 = second_power_moment(side, 2 * j + 3, x, q_power);
  }
  return sum * 0.5;
}

/// 3 int (1 - F) c^2 dc for v = 1/n < 0.29. The transmittance bends at c ~ 1/n, so c + 1/n runs geometrically; its
/// singularities then stay 2.5 half-lengths away and 16 Gauss points leave less than 1e-17.
template <typename T>
T second_transmitted(Side side, const T& v) {
  using std::exp;
  using std::expm1;
  using std::log;
  using std::sqrt;
  const T n = 1.0 / v;
  const auto integrand = [&](const T& y) {
    const T rise = exp(y) * v, c = expm1(y) * v, s = sqrt(c * c + (n - 1.0) * (n + 1.0));
    return T(rise * fresnel_transmittance(c, n) * (side == Side::thin ? T(c * c) : T(s * c * v * v * v)));
  };
  return 3.0 * gauss_legendre(T(0.0), T(log(n + 1.0)), integrand);
}

/// 3 int F c^2 dc from that side; from the dense one with all that lies beyond the critical angle.
template <typename T>
T second_moment(Side side, const T& eta) {
  using std::sqrt;
  const T x = contrast(eta);
  if (x == 0.0) return x * 0.0;
  if (x >= 0.56) return 1.0 - second_transmitted(side, inverse_index(eta));
  const T below = side == Side::thin ? T(1.0 - x) : T(1.0 + x);  // a, a/n = 2 sqrt(x)/(1 -+ x)
  const T cubed = 8.0 * x * sqrt(x) / (below * below * below), mean = 0.375 * second_series(side, x);
  return side == Side::thin ? T(cubed * mean) : T(cubed * (1.0 + mean));
}

/// 1 - second_moment.
template <typename T>
T second_complement(Side side, const T& eta) {
  if (contrast(eta) < 0.56) return 1.0 - second_moment(side, eta);
  return second_transmitted(side, inverse_index(eta));
}

}  // namespace fresnel_detail

/// Second moment from OUTSIDE: 3 int_0^1 F(c, eta) c^2 dc = 3 C_2(1/eta).
template <typename T>
T second_moment_external(const T& eta) {
  using namespace fresnel_detail;
  return second_moment(eta >= 1.0 ? Side::thin : Side::dense, eta);
}

/// Second moment from INSIDE: 3 int_0^1 F(c, 1/eta) c^2 dc = 3 C_2(eta).
template <typename T>
T second_moment_internal(const T& eta) {
  using namespace fresnel_detail;
  return second_moment(eta >= 1.0 ? Side::dense : Side::thin, eta);
}

/// C_phi = (1 - 2 C_1(eta))/4: exitance per fluence, in (0, 1/4].
template <typename T>
T exitance_weight_fluence(const T& eta) {
  return 0.25 * diffuse_transmittance_internal(eta);
}

/// C_E = (1 - 3 C_2(eta))/2: exitance per net flux, in (0, 1/2].
template <typename T>
T exitance_weight_flux(const T& eta) {
  using namespace fresnel_detail;
  return 0.5 * second_complement(eta >= 1.0 ? Side::dense : Side::thin, eta);
}

/// A = (1 + 3 C_2)/(1 - 2 C_1) = (1 - C_E)/(2 C_phi) of the modified extrapolated boundary z_b = 2 A D; 1 at eta = 1.
template <typename T>
T modified_boundary_a(const T& eta) {
  return (1.0 + second_moment_internal(eta)) / diffuse_transmittance_internal(eta);
}

}  // namespace opaline
