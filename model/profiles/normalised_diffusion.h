// Normalised diffusion (Burley 2015; Christensen & Burley 2015): two exponentials over r, fitted by its authors to
// Monte-Carlo profiles of index-matched half spaces, single scattering included.
//
//   R_d(r) = A/(8 pi d r) ( exp(-r/d) + exp(-r/(3d)) ),  d = 1/(sigma_t' s(A_0)),  2 pi int R_d r dr = A
//
// As a profile of a medium it needs the albedo. Stated choices, u = sqrt(1 - alpha'):
//   A_0      index-matched albedo of the half space; `searchlight` (a normal beam): Prahl's fit
//            (1-u)(1-0.128u)/(1+1.83u); `diffuse` light: van de Hulst's (1-u)(1-0.139u)/(1+1.17u)
//   s(A_0)   searchlight 1.85 - A_0 + 7|A_0 - 0.8|^3; diffuse 1.9 - A_0 + 3.5 (A_0 - 0.8)^2
//   A        A_0 behind the boundary (Saunderson 1942): A_0 (1 - F_dr)/(1 - F_dr A_w), A_w van de Hulst's;
//            A = A_0 at eta = 1, A = 1 without absorption
// Against transport, searchlight: A within 2.5 % for eta 1 to 1.5 and alpha' >= 0.9 (eta 1.3: 4 % high at 0.8); the
// share of the flux that lies at the wrong radius is 3 % at eta 1 and alpha' 0.8 to 0.95, 16 % at 0.999; at eta 1.3, of
// which the shape knows nothing, 14 % at 0.9 and 40 % at 0.999.
//
// The 1/r at the axis: with rho = sqrt(r^2 + c^2), c = d/100, and S(rho) = (exp(-rho/d) + 3 exp(-rho/(3d)))/4, the
// share of the flux beyond rho,
//   R_d(r) = A/(2 pi rho) [ (exp(-rho/d) + exp(-rho/(3d)))/(4d) + (1 - S(c))/c exp(-(rho - c)/c) ]
// is finite and smooth in r^2, has the same integral, a closed cumulative and closed sampling, and differs from the
// published profile by (c/r)^2/2 beyond a few c: 0.5 % at d/10, 5e-5 at d.
//
// Units and normalisation: conventions.h. sigma_t' in [1e-90, 1e90] 1/mm, r in [0, 1e150] mm. At sigma_a = 0 the
// derivative by sigma_a is infinite (A falls like its root): a dual number sees a constant u = 0 there.
#pragma once

#include "model/fresnel.h"

#include <algorithm>
#include <cmath>

namespace opaline {

/// Reflectance of an index-matched half space, isotropic scattering, u = sqrt(1 - alpha'): fits within 0.0021
/// (van de Hulst) and 0.0017 (Prahl) of the exact values.
template <typename T>
T half_space_albedo_diffuse(const T& u) {
  return (1.0 - u) * (1.0 - 0.139 * u) / (1.0 + 1.17 * u);
}
template <typename T>
T half_space_albedo_normal(const T& u) {
  return (1.0 - u) * (1.0 - 0.128 * u) / (1.0 + 1.83 * u);
}

enum class Illumination { searchlight, diffuse };

template <typename T, Illumination lit>
struct NormalisedDiffusion {
  static constexpr double core_share = 0.01;  ///< c/d

  T albedo;  ///< A, per transmitted flux
  T d, c;    ///< shape's length, core's length [mm]

  explicit NormalisedDiffusion(const Medium<T>& medium) {
    using std::abs;
    using std::sqrt;
    const T sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    const T u = medium.sigma_a == 0.0 ? T(0.0) : T(sqrt(medium.sigma_a / sigma_t_prime));
    const T inner = half_space_albedo_diffuse(u);
    const T a = lit == Illumination::diffuse ? inner : half_space_albedo_normal(u), x = a - 0.8;
    const T s = lit == Illumination::diffuse ? T(1.9 - a + 3.5 * x * x) : T(1.85 - a + 7.0 * x * x * abs(x));
    const T through = diffuse_transmittance_internal(medium.eta);
    albedo = a * through / (through + (1.0 - through) * (1.0 - inner));
    d = 1.0 / (sigma_t_prime * s);
    c = core_share * d;
  }

  /// S: share of the published profile's flux beyond rho.
  static T beyond(const T& rho_over_d) {
    using std::exp;
    return 0.25 * (exp(-rho_over_d) + 3.0 * exp(-rho_over_d / 3.0));
  }
  static T core_flux() {
    using std::expm1;
    return T(-0.25 * (std::expm1(-core_share) + 3.0 * std::expm1(-core_share / 3.0)));
  }

  /// R_d [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const {
    using std::exp;
    using std::sqrt;
    const T rho = sqrt(r * r + c * c);
    const T shape = (exp(-rho / d) + exp(-rho / (3.0 * d))) / (4.0 * d);
    return albedo / (2.0 * pi * rho) * (shape + core_flux() / c * exp(1.0 - rho / c));
  }

  /// 2 pi int_0^inf R_d r dr.
  T total() const { return albedo; }

  /// 2 pi int_0^r R_d s ds.
  T cumulative(const T& r) const {
    using std::expm1;
    using std::sqrt;
    const T h = r * (r / (sqrt(r * r + c * c) + c)), x = h / d;  // h = rho - c
    const T outer = -0.25 * (std::exp(-core_share) * expm1(-x) + 3.0 * std::exp(-core_share / 3.0) * expm1(-x / 3.0));
    return albedo * (outer - core_flux() * expm1(-h / c));
  }

  /// Of R_d(sqrt(r^2 + z^2)) over a plane, see Profile::plane_spectrum: each term exp(-s rho)/rho has
  /// 2 pi exp(-beta h)/beta, beta^2 = s^2 + k^2, h^2 = c^2 + z^2.
  T plane_spectrum(const T& k, const T& z) const {
    using std::exp;
    using std::sqrt;
    const T h = sqrt(c * c + z * z);
    const auto term = [&](const T& s, const T& from) {
      const T beta = sqrt(s * s + k * k);
      return T(exp(s * from - beta * h) / beta);
    };
    const T shape = (term(T(1.0 / d), T(0.0)) + term(T(1.0 / (3.0 * d)), T(0.0))) / (4.0 * d);
    return albedo * (shape + core_flux() / c * term(T(1.0 / c), c));
  }

  /// Radius with density 2 pi r R_d(r)/total() for uniform xi in [0, 1); closed, not monotone in xi: the core for xi
  /// below its share, else the root of S(rho) = 1 - xi. With y = exp(-rho/(3d)) that is y^3 + 3y = 4 (1 - xi), whose
  /// real root is 2 sinh(asinh(2 (1 - xi))/3).
  double sample(double xi) const {
    if (!(xi > 0)) return 0;
    const double share = core_flux();
    const double h =
        xi < share ? -c * std::log1p(-xi / share) : -3 * d * std::log(2 * std::sinh(std::asinh(2 * (1 - xi)) / 3)) - c;
    return std::sqrt(std::max(0.0, h) * (std::max(0.0, h) + 2 * c));
  }

  T core_radius() const { return c; }
};

template <typename T>
using SearchlightNormalisedDiffusion = NormalisedDiffusion<T, Illumination::searchlight>;
template <typename T>
using DiffuseNormalisedDiffusion = NormalisedDiffusion<T, Illumination::diffuse>;

}  // namespace opaline
