// The directional dipole (directional_dipole.h) of a normal beam on a plane, as a radial profile: the vectors drop out.
//
//   R_d(r) = 1/(4 pi) { C_phi/D (Y_r - Y_v) + 3 C_E D S_r/d_r^3 + (3 C_phi Z + C_E (3 D + Z)) S_v/d_v^3 - 3 C_E D Z^2
//   V/d_v^5 } Y = exp(-s d)/d,  S = (1 + s d) exp(-s d),  V = (3 (1 + s d) + (s d)^2) exp(-s d) d_r^2 = r^2 + D^2 + 2 D
//   r/sqrt(1 + r^2/d_e^2),  d_v^2 = r^2 + Z^2,  Z = 2 A d_e,  d_e = 2.131 D/sqrt(alpha')
//
// Y_r - Y_v is taken without cancellation: far from the beam it is all there is. Near the axis R_d is a cone.
// Not energy conserving: see directional_dipole.h. alpha' = 0 leaves the real source alone: the model has no albedo.
// Units and normalisation: conventions.h. sigma_t' in [1e-60, 1e60]. Dual numbers as in standard_dipole.h.
#pragma once

#include "model/fresnel_moments.h"
#include "model/profiles/poles.h"
#include "model/profiles/yukawa.h"

namespace opaline {

/// (3 (1 + y) + y^2) exp(-y), y = sqrt(t): smooth in t to first order, with derivative -(1 + y) exp(-y)/2; a dual
/// number as in `screening`.
template <typename T>
T screening_of_curvature(const T& t) {
  using std::exp;
  using std::sqrt;
  if constexpr (requires {
                  t.a;
                  t.v;
                }) {
    return T(screening_of_curvature(t.a), t.v * (-0.5 * screening(t.a)));
  } else {
    const T y = sqrt(t);
    return y < 1e4 ? T((3.0 * (1.0 + y) + t) * exp(-y)) : T(0.0);
  }
}

/// exp(-s d)/d less exp(-s (d + gap))/(d + gap), gap > 0.
template <typename T>
T yukawa_difference(const T& s_squared, const T& d, const T& gap) {
  using std::exp;
  using std::sqrt;
  const auto difference = [&](const T& s) {
    return T(exp(-s * d) / (d + gap) * gap * (1.0 / d + s * mean_decay(T(s * gap))));
  };
  if constexpr (requires {
                  s_squared.a;
                  s_squared.v;
                }) {  // by s^2 in closed form: finite at 0
    using Scalar = decltype(s_squared.a);
    const Scalar s = sqrt(s_squared.a);
    const Scalar slope = -0.5 * exp(-s * d.a) * gap.a * mean_decay(Scalar(s * gap.a));
    return difference(T(s)) + T(Scalar(0.0), s_squared.v * slope);
  } else {
    return difference(T(sqrt(s_squared)));
  }
}

template <typename T>
struct DirectionalNormalBeam {
  T diffusion;         ///< D [mm]
  T sigma_tr_squared;  ///< [1/mm^2]
  T inverse_d_e;       ///< 1/d_e [1/mm]; 0: no image
  T image_height;      ///< Z [mm]
  T fluence_weight;    ///< C_phi
  T flux_weight;       ///< C_E

  explicit DirectionalNormalBeam(const Medium<T>& medium) {
    using std::sqrt;
    const T sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    diffusion = 1.0 / (3.0 * sigma_t_prime);
    sigma_tr_squared = medium.sigma_a / diffusion;
    const bool dark = medium.sigma_s_prime == 0.0;
    inverse_d_e = dark ? T(0.0) : T(sqrt(medium.sigma_s_prime / sigma_t_prime) / (2.131 * diffusion));
    image_height = dark ? T(0.0) : T(2.0 * modified_boundary_a(medium.eta) / inverse_d_e);
    fluence_weight = exitance_weight_fluence(medium.eta);
    flux_weight = exitance_weight_flux(medium.eta);
  }

  /// R_d [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const {
    using std::exp;
    using std::sqrt;
    const T q = r * r, bend = r * inverse_d_e, lift = diffusion * (diffusion + 2.0 * r / sqrt(1.0 + bend * bend));
    const T d_r = sqrt(q + lift), y = sigma_tr_squared * d_r * d_r;
    const T near = 3.0 * flux_weight * diffusion * screening(y) / (d_r * d_r * d_r);
    if (image_height == 0.0) return (near + fluence_weight / diffusion * alone(d_r)) / (4.0 * pi);
    const T &z = image_height, d_v = sqrt(q + z * z), y_v = sigma_tr_squared * d_v * d_v;
    const T gap = (z * z - lift) / (d_v + d_r), cube = d_v * d_v * d_v;
    const T fluence = fluence_weight / diffusion * yukawa_difference(sigma_tr_squared, d_r, gap);
    const T rising = (3.0 * fluence_weight * z + flux_weight * (3.0 * diffusion + z)) * screening(y_v) / cube;
    const T z_over_d = z / d_v;
    const T falling = 3.0 * flux_weight * diffusion * z_over_d * z_over_d * screening_of_curvature(y_v) / cube;
    return (fluence + near + (rising - falling)) / (4.0 * pi);
  }

  /// The cone's tip takes what it can: R_d has lost a twentieth of its peak there.
  T core_radius() const { return 0.02 * diffusion; }

 private:
  T alone(const T& d) const {
    using std::exp;
    using std::sqrt;
    return exp(-(sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(sigma_tr_squared))) * d) / d;
  }
};

}  // namespace opaline
