// The standard dipole (Jensen, Marschner, Levoy & Hanrahan 2001, eq. 4 with the second term's stray
// 1/sigma_t' removed, as in Jensen & Buhler 2002): one real source a transport mean free path deep
// and its mirror image above the extrapolated boundary.
//
//   R_d(r) = alpha'/(4 pi) [ z_r (1 + s d_r) e^(-s d_r)/d_r^3 + z_v (1 + s d_v) e^(-s d_v)/d_v^3 ]
//
// with s = sigma_tr = sqrt(3 sigma_a sigma_t'), z_r = 1/sigma_t', z_v = z_r (1 + 4 A/3) and d^2 = r^2 + z^2.
// Units and normalisation: conventions.h. Valid numerically for sigma_t' in [1e-90, 1e90] 1/mm and r in
// [0, 1e150] mm; gradients while
// sigma_t' r^2 < 1e300. Physically where multiple scattering dominates: see the registry row.
//
// Limits: alpha' = 0 gives R_d = 0; sigma_a = 0 gives s = 0 and an exact 1/r^3 tail. As a function of
// sigma_a at 0, R_d(r) has a finite derivative, which a ceres::Jet gets exactly; total() falls like
// sqrt(sigma_a), so its derivative is minus infinity there: a Jet then sees a constant sigma_tr = 0.
#pragma once

#include "model/fresnel.h"
#include "model/profiles/poles.h"
#include "model/scalar.h"

namespace opaline {

template <typename T>
struct StandardDipole {
  T alpha_prime;       ///< reduced albedo, 0 .. 1
  T sigma_tr_squared;  ///< [1/mm^2]
  T sigma_tr;          ///< effective transport coefficient [1/mm]
  T z_r, z_v;          ///< depth of the real source, height of the image [mm]
  double near_share;   ///< of the total that the real source has

  explicit StandardDipole(const Medium<T>& medium) {
    using std::sqrt;
    const T sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    alpha_prime = medium.sigma_s_prime / sigma_t_prime;
    sigma_tr_squared = 3.0 * medium.sigma_a * sigma_t_prime;
    sigma_tr = sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(sigma_tr_squared));
    z_r = 1.0 / sigma_t_prime;
    z_v = z_r * (1.0 + 4.0 / 3.0 * dipole_boundary_a(medium.eta));
    near_share = near_pole_share(value_of(z_r), value_of(z_v), value_of(sigma_tr));
  }

  /// R_d [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const { return evaluate_squared(T(r * r)); }

  /// R_d as a function of q = r^2 [mm^2]: smooth at q = 0.
  T evaluate_squared(const T& q) const { return dipole_evaluate_squared(q, alpha_prime, z_r, z_v, sigma_tr_squared); }

  /// 2 pi int_0^inf R_d r dr.
  T total() const {
    using std::exp;
    return 0.5 * alpha_prime * (exp(-sigma_tr * z_r) + exp(-sigma_tr * z_v));
  }

  /// 2 pi int_0^r R_d s ds, relative error below 1e-14.
  T cumulative(const T& r) const {
    return 0.5 * alpha_prime * (pole_cumulative(r, z_r, sigma_tr) + pole_cumulative(r, z_v, sigma_tr));
  }

  /// Of R_d(sqrt(r^2 + z^2)) over a plane, see Profile::plane_spectrum.
  T plane_spectrum(const T& k, const T& z) const {
    return 0.5 * alpha_prime * (pole_spectrum(k, z, z_r, sigma_tr) + pole_spectrum(k, z, z_v, sigma_tr));
  }

  /// Radius with density 2 pi r R_d(r)/total() for uniform xi in [0, 1); exact, not monotone in xi.
  double sample(double xi) const { return sample_pole_pair(z_r, z_v, sigma_tr, near_share, xi); }

  /// R_d has lost a tenth of its peak at about a quarter of this length [mm].
  T core_radius() const { return z_r; }
};

}  // namespace opaline
