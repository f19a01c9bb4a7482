// The better dipole (d'Eon 2012, "A Better Dipole"): the standard dipole's source and image with Grosjean's diffusion
// coefficient, the second Fresnel moment in the boundary, and exitance from fluence and flux together.
//
//   R_d(r) = alpha'^2 { C_E (P(r; z_r) + P(r; z_v))/2 + (1 - C_E) G(r; z_r, z_v) }
//
// with P of poles.h and G of yukawa.h, s = sigma_tr = sqrt(sigma_a/D), D = (2 sigma_a + sigma_s')/(3 sigma_t'^2),
// z_r = 1/sigma_t', z_v = z_r + 4 A D, and C_E, A of fresnel_moments.h. The paper's weights are C_E and C_phi/D; with
// 2 A C_phi = 1 - C_E the fluence term becomes a mean over the gap 4 A D and energy conservation is plain:
// without absorption both integrals are 1 and so is the total.
//
// Units and normalisation: conventions.h. sigma_t' in [1e-70, 1e70] 1/mm, r in [0, 1e150] mm; eta as in
// fresnel_moments.h. It is multiple scattering only, yet its total reaches 1: adding single scattering
// overshoots (1.065 at alpha' 0.999, eta 1). Dual numbers: as in standard_dipole.h.
#pragma once

#include "model/fresnel_moments.h"
#include "model/profiles/inverse.h"
#include "model/profiles/poles.h"
#include "model/profiles/yukawa.h"

namespace opaline {

template <typename T>
struct BetterDipole {
  T albedo_squared;    ///< alpha'^2, 0 .. 1
  T flux_weight;       ///< C_E
  T sigma_tr_squared;  ///< [1/mm^2]
  T sigma_tr;          ///< effective transport coefficient [1/mm]
  T z_r, z_v;          ///< depth of the real source, height of the image [mm]

  explicit BetterDipole(const Medium<T>& medium) {
    using std::sqrt;
    const T sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    const T alpha_prime = medium.sigma_s_prime / sigma_t_prime;
    albedo_squared = alpha_prime * alpha_prime;
    flux_weight = exitance_weight_flux(medium.eta);
    z_r = 1.0 / sigma_t_prime;
    const T diffusion = z_r * (2.0 - alpha_prime) / 3.0;
    sigma_tr_squared = medium.sigma_a / diffusion;
    sigma_tr = sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(sigma_tr_squared));
    z_v = z_r + 4.0 * modified_boundary_a(medium.eta) * diffusion;
  }

  /// R_d [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const { return evaluate_squared(T(r * r)); }

  /// R_d as a function of q = r^2 [mm^2]: smooth at q = 0.
  T evaluate_squared(const T& q) const {
    const T poles = pole_evaluate_squared(q, z_r, sigma_tr_squared) + pole_evaluate_squared(q, z_v, sigma_tr_squared);
    const T gap = yukawa_gap_squared(q, z_r, z_v, sigma_tr_squared);
    return albedo_squared * (0.5 * flux_weight * poles + (1.0 - flux_weight) * gap);
  }

  /// 2 pi int_0^inf R_d r dr.
  T total() const {
    using std::exp;
    const T poles = 0.5 * (exp(-sigma_tr * z_r) + exp(-sigma_tr * z_v));
    return albedo_squared * (flux_weight * poles + (1.0 - flux_weight) * yukawa_gap_total(z_r, z_v, sigma_tr));
  }

  /// 2 pi int_0^r R_d s ds, relative error below 1e-13.
  T cumulative(const T& r) const {
    const T poles = pole_cumulative(r, z_r, sigma_tr) + pole_cumulative(r, z_v, sigma_tr);
    const T gap = yukawa_gap_cumulative(r, z_r, z_v, sigma_tr);
    return albedo_squared * (0.5 * flux_weight * poles + (1.0 - flux_weight) * gap);
  }

  /// Of R_d(sqrt(r^2 + z^2)) over a plane, see Profile::plane_spectrum.
  T plane_spectrum(const T& k, const T& z) const {
    const T poles = pole_spectrum(k, z, z_r, sigma_tr) + pole_spectrum(k, z, z_v, sigma_tr);
    const T gap = yukawa_gap_spectrum(k, z, z_r, z_v, sigma_tr);
    return albedo_squared * (0.5 * flux_weight * poles + (1.0 - flux_weight) * gap);
  }

  /// Radius with density 2 pi r R_d(r)/total() for uniform xi in [0, 1): the inverse of the cumulative.
  double sample(double xi) const {
    const double whole = total();
    if (!(whole > 0)) return 0;
    return invert_share([&](double r) { return cumulative(r) / whole; },
                        [&](double r) { return 2 * pi * r * evaluate(r) / whole; },
                        sample_pole(z_r, sigma_tr, std::max(xi, 1e-200)), xi);
  }

  T core_radius() const { return z_r; }
};

}  // namespace opaline
