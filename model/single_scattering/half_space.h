// Exact single scattering in a homogeneous half space under a smooth Fresnel boundary; phase function of Henyey &
// Greenstein or of Schlick. Layers: layered.h.
//
//   single_scattering_profile   R1(r) of a normal pencil beam [1/mm^2]: exitance per unit of flux that has entered
//   single_scattering_cumulative, _total     2 pi int_0^r R1 r dr, to infinity
//   hanrahan_krueger_brdf       the same light as a BRDF for plane illumination [1/sr], of a layer too
//
// R1(r) = int_{t_c}^inf sigma_s exp(-sigma_t (t + d)) p(mu) T(mu) mu/d^2 dt with depth t, d^2 = r^2 + t^2, mu = t/d, p
// at the cosine -mu (the light turns back), T = 1 - F(mu, 1/eta), and t_c where total internal reflection ends. With mu
// = cos(theta) and w = cot(theta/2) it is
//   R1(r) = (2 sigma_s/r) int_{w_c}^inf exp(-sigma_t r w) p T mu/(1 + w^2) dw,   mu = (w^2 - 1)/(w^2 + 1),
// smooth for every r. It grows like 1/r towards the axis (R1(0) is infinite), so it isn't a row of the profile
// registry. Whoever needs a finite centre holds it at single_scattering_cumulative(m, c)/(pi c^2) below a radius c,
// which keeps the integral: about twice R1(c). Error of the quadratures: below 2e-10 relative for sigma_t r from
// 1e-6 to 50.
//
// Light reflected back inside by the boundary before its one scattering is not in it: there is none (it would
// have scattered); light reflected inside after it belongs to multiple scattering.
// Source: Jensen et al. 2001 eq. 6 and Hanrahan & Krueger 1993; the beam's integral after Habel et al. 2013. The
// 1/eta^2 in the BRDF, missing from several texts, is what makes its integral equal the total here.
#pragma once

#include "model/fresnel.h"
#include "model/phase.h"
#include "model/quadrature.h"

namespace opaline {

enum class Phase { henyey_greenstein, schlick };

/// A medium whose direction of scattering matters.
///   sigma_a, sigma_s  absorption, scattering (not reduced) [1/mm], >= 0, sum > 0
///   g                 parameter of the phase function, in (-1, 1): Henyey & Greenstein's mean cosine, or Schlick's k,
///                     for which schlick_k(g) imitates the former
///   eta               relative refraction index inside / outside
template <typename T>
struct ScatteringMedium {
  T sigma_a{}, sigma_s{}, g{}, eta{1};
  Phase phase = Phase::henyey_greenstein;
};

/// The medium's phase function [1/sr].
template <typename T>
T phase_function(const ScatteringMedium<T>& m, const T& cos_theta) {
  return m.phase == Phase::schlick ? schlick_phase(cos_theta, m.g) : henyey_greenstein(cos_theta, m.g);
}

namespace single_scattering_detail {

/// cot(theta/2) at the critical angle; 1 if there is none.
template <typename T>
T critical_cotangent(const T& eta) {
  using std::sqrt;
  if (eta <= 1.0) return T(1.0);
  return eta + sqrt((eta - 1.0) * (eta + 1.0));  // sqrt((1 + mu_c)/(1 - mu_c))
}

/// p T mu/(1 + w^2) of light that is scattered towards the surface at cot(theta/2) = w.
template <typename T>
T escaping(const ScatteringMedium<T>& m, const T& w) {
  const T one_plus = 1.0 + w * w, mu = (w - 1.0) * (w + 1.0) / one_plus;
  return phase_function(m, T(-mu)) * fresnel_transmittance(mu, T(1.0 / m.eta)) * mu / one_plus;
}

}  // namespace single_scattering_detail

/// R1(r) [1/mm^2], r > 0 [mm].
template <typename T>
T single_scattering_profile(const ScatteringMedium<T>& m, const T& r) {
  using std::exp;
  const T sigma_t = m.sigma_a + m.sigma_s, w_c = single_scattering_detail::critical_cotangent(m.eta);
  const auto integrand = [&](const T& v) {
    return T(exp(-sigma_t * r * v) * single_scattering_detail::escaping(m, T(w_c + v)));
  };
  return 2.0 * m.sigma_s / r * exp(-sigma_t * r * w_c) * integrate_half_line<T>(integrand);
}

/// 2 pi int_0^r R1 s ds, r >= 0 [mm]: with (1 - exp(-sigma_t r w))/(sigma_t w) for the exponential.
template <typename T>
T single_scattering_cumulative(const ScatteringMedium<T>& m, const T& r) {
  using std::expm1;
  const T sigma_t = m.sigma_a + m.sigma_s, w_c = single_scattering_detail::critical_cotangent(m.eta);
  const auto integrand = [&](const T& v) {
    const T w = w_c + v;
    return T(-expm1(-sigma_t * r * w) / w * single_scattering_detail::escaping(m, w));
  };
  return 4.0 * pi * m.sigma_s / sigma_t * integrate_half_line<T>(integrand);
}

/// 2 pi int_0^inf R1 r dr = 2 pi alpha int p T mu/(1 + mu) dmu, for the normal beam.
template <typename T>
T single_scattering_total(const ScatteringMedium<T>& m) {
  const T w_c = single_scattering_detail::critical_cotangent(m.eta);
  const auto integrand = [&](const T& v) { return T(single_scattering_detail::escaping(m, T(w_c + v)) / (w_c + v)); };
  return 4.0 * pi * m.sigma_s / (m.sigma_a + m.sigma_s) * integrate_half_line<T>(integrand);
}

/// Single scattering of a layer of optical thickness tau (infinite for a half space) as a BRDF [1/sr] for incident
/// and outgoing directions outside: cosines cos_i, cos_o in (0, 1] and cos_phase, the cosine between the directions
/// of travel INSIDE before and after scattering. Light that reaches the layer's far side is lost. Reciprocal.
template <typename T>
T hanrahan_krueger_brdf(const ScatteringMedium<T>& m, const T& cos_i, const T& cos_o, const T& cos_phase,
                        const T& tau) {
  using std::expm1;
  using std::sqrt;
  const T eta_squared = m.eta * m.eta;
  const auto inside = [&](const T& c) { return T(sqrt(1.0 - (1.0 - c) * (1.0 + c) / eta_squared)); };
  if ((1.0 - cos_i) * (1.0 + cos_i) >= eta_squared || (1.0 - cos_o) * (1.0 + cos_o) >= eta_squared) return T(0.0);
  const T mu_i = inside(cos_i), mu_o = inside(cos_o);
  const T through = fresnel_transmittance(cos_i, m.eta) * fresnel_transmittance(cos_o, m.eta);
  const T depth = -expm1(-tau * (1.0 / mu_i + 1.0 / mu_o));
  const T albedo = m.sigma_s / (m.sigma_a + m.sigma_s);
  return albedo * through * phase_function(m, cos_phase) * depth / (eta_squared * (mu_i + mu_o));
}

}  // namespace opaline
