// The directional dipole (Frisvad, Hachisuka & Kjeldsen 2014): the diffuse BSSRDF of a refracted ray, which knows the
// ray's direction. A function of two points, their normals and a direction, so not a row of the profile registry.
//
//   S_d' = max(0, S'(x, w, d_r) - S'(x - 2 A d_e n*, w_v, d_v))
//   S'(x, w, d) = exp(-s d)/(4 pi^2 d^3) { C_phi [ d^2/D + 3 (1 + s d) x.w ]
//       - C_E [ 3 D (1 + s d) w.n_o - ((1 + s d) + 3 D (3 (1 + s d) + (s d)^2)/d^2 x.w) x.n_o ] }
//
// with x from entry to exit [mm], w the refracted direction of travel, D = 1/(3 sigma_t'), s = sqrt(sigma_a/D),
// d_e = 2.131 D/sqrt(alpha'), n* the modified normal and w_v = w - 2 (w.n*) n*; C_phi, C_E, A of fresnel_moments.h.
//
// Value: 1/mm^2/sr per unit of flux that has entered, times pi the radiant exitance; the published S_d has an extra
// 1/(1 - 2 C_1(1/eta)), this project's exit lobe (conventions.h). Diffuse part only: the paper's S_deltaE, light that
// scatters on along the ray, is not in it. Scalar T; sigma_a, sigma_s' > 0.
//
// What it cannot do, as published: it doesn't conserve energy (normal beam, eta 1: 1.25 at alpha' 0.999), is not
// reciprocal, is far too high near the entry of an oblique ray, and has no n* at x = 0 (here n_i is taken). It is
// right asymptotically in r.
#pragma once

#include "model/fresnel_moments.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {

template <typename T>
using Vector3 = std::array<T, 3>;

template <typename T>
T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// a + k b.
template <typename T>
Vector3<T> along(const Vector3<T>& a, const T& k, const Vector3<T>& b) {
  return {a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]};
}

template <typename T>
struct DirectionalDipole {
  T diffusion;       ///< D [mm]
  T sigma_tr;        ///< [1/mm]
  T sigma_t;         ///< NOT reduced [1/mm]
  T extrapolation;   ///< d_e [mm]
  T boundary_a;      ///< A
  T fluence_weight;  ///< C_phi
  T flux_weight;     ///< C_E

  /// g: mean cosine of the phase function, in (-1, 1); it enters only where the light falls on the back.
  DirectionalDipole(const Medium<T>& medium, const T& g) {
    using std::sqrt;
    const T sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    diffusion = 1.0 / (3.0 * sigma_t_prime);
    sigma_tr = sqrt(medium.sigma_a / diffusion);
    sigma_t = medium.sigma_a + medium.sigma_s_prime / (1.0 - g);
    extrapolation = 2.131 * diffusion / sqrt(medium.sigma_s_prime / sigma_t_prime);
    boundary_a = modified_boundary_a(medium.eta);
    fluence_weight = exitance_weight_fluence(medium.eta);
    flux_weight = exitance_weight_flux(medium.eta);
  }

  /// S_d' for light that enters at the origin with normal n_i, travelling along w, and leaves at x with normal n_o.
  T evaluate(const Vector3<T>& x, const Vector3<T>& w, const Vector3<T>& n_i, const Vector3<T>& n_o) const {
    using std::sqrt;
    const Vector3<T> normal = modified_normal(x, n_i);
    const Vector3<T> x_v = along(x, T(-2.0 * boundary_a * extrapolation), normal);
    const Vector3<T> w_v = along(w, T(-2.0 * dot(w, normal)), normal);
    const T real = ray(x, w, real_distance(x, w, n_o), n_o), image = ray(x_v, w_v, T(sqrt(dot(x_v, x_v))), n_o);
    return real > image ? T(real - image) : T(0.0);
  }

  /// Radiant exitance at distance r [mm] from a normal beam on a plane, per unit of entered flux [1/mm^2].
  T normal_beam(const T& r) const {
    const Vector3<T> up = {T(0.0), T(0.0), T(1.0)}, down = {T(0.0), T(0.0), T(-1.0)};
    return pi * evaluate({r, T(0.0), T(0.0)}, down, up, up);
  }

 private:
  /// The component of n_i across x, normalised; n_i itself where x is 0 or along n_i.
  static Vector3<T> modified_normal(const Vector3<T>& x, const Vector3<T>& n_i) {
    using std::sqrt;
    const T r_squared = dot(x, x);
    if (!(r_squared > 0.0)) return n_i;
    const Vector3<T> across = along(n_i, T(-dot(n_i, x) / r_squared), x);
    const T length_squared = dot(across, across);
    if (!(length_squared > 0.0)) return n_i;
    const T inverse = 1.0 / sqrt(length_squared);
    return {across[0] * inverse, across[1] * inverse, across[2] * inverse};
  }

  /// d_r: keeps the real source's singularity away from the surface.
  T real_distance(const Vector3<T>& x, const Vector3<T>& w, const Vector3<T>& n_o) const {
    using std::sqrt;
    const T r_squared = dot(x, x), mu = -dot(n_o, w), shift = diffusion * mu;
    if (!(mu > 0.0)) return sqrt(r_squared + 1.0 / (9.0 * sigma_t * sigma_t));
    const T along_ray = dot(x, w), off_ray = r_squared - along_ray * along_ray;
    const T ratio = off_ray / (r_squared + extrapolation * extrapolation);
    const T minus_cos_beta = ratio > 0.0 ? T(sqrt(ratio)) : T(0.0);
    return sqrt(r_squared + shift * (shift + 2.0 * extrapolation * minus_cos_beta));
  }

  T ray(const Vector3<T>& x, const Vector3<T>& w, const T& d, const Vector3<T>& n_o) const {
    using std::exp;
    const T sd = sigma_tr * d, one = 1.0 + sd, d2 = d * d, x_w = dot(x, w);
    const T fluence = d2 / diffusion + 3.0 * one * x_w;
    const T across = one + 3.0 * diffusion * (3.0 * one + sd * sd) / d2 * x_w;
    const T flux = 3.0 * diffusion * one * dot(w, n_o) - across * dot(x, n_o);
    return exp(-sd) / (4.0 * pi * pi * d2 * d) * (fluence_weight * fluence - flux_weight * flux);
  }
};

}  // namespace opaline
