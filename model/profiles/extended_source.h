// Diffusion from the whole refracted beam instead of one point: better dipoles at every depth t, weighted by the
// light scattered there. For a beam at normal incidence
//
//   R_d(r) = alpha'^2 int_0^inf sigma_t' exp(-sigma_t' t) kappa(t, r) E(t, r) dt
//   E = C_E (P(r; t) + P(r; t + gap))/2 + (1 - C_E) G(r; t, t + gap),   gap = 4 A D      (better_dipole.h)
//
//   ExtendedSource        kappa = 1: what quantised diffusion (d'Eon & Irving 2011) sums by Gaussians
//   PhotonBeamDiffusion   kappa = 1 - exp(-2 sigma_t' (d_r + t)), d_r^2 = r^2 + t^2: the empirical correction near
//                         the source of Habel, Christensen & Jarosz 2013
//
// Both are multiple scattering only. Near the axis the integral grows like 1/r (like log r with kappa); the sum
// below is a superposition of finitely many dipoles, so it is finite and flat within core_radius = l/500,
// l = 1/sigma_t', with the source's strength preserved.
//
// Quadrature: the trapezoid rule in log t, step 0.4, from l/500 to 44 l; what lies above the first node is put on the
// first two. Relative error against adaptive quadrature: below 5e-8 for r > l/2, 5e-7 at l/5, 3e-6 at l/10, 3e-4 at
// l/50; at l/200 0.3 % with kappa, 4 % without.
//
// Units and normalisation: conventions.h. sigma_t' in [1e-70, 1e70] 1/mm, r in [0, 1e150] mm, eta as in
// fresnel_moments.h. Dual numbers: as in standard_dipole.h.
#pragma once

#include "model/fresnel_moments.h"
#include "model/profiles/poles.h"
#include "model/profiles/yukawa.h"

#include <array>

namespace opaline {

/// Depths [mean free paths] and weights of the source; the weights add up to 1.
struct SourceDepths {
  static constexpr std::size_t count = 26;
  static constexpr double first = 0.002, step = 0.4;
  std::array<double, count> depth, weight;

  static double trapezoid(double t) { return step * t * std::exp(-t); }

  SourceDepths() {
    for (std::size_t i = 0; i < count; ++i) {
      depth[i] = first * std::exp(step * static_cast<double>(i));
      weight[i] = trapezoid(depth[i]);
    }
    // What lies above the first node goes to the first two, with its mass and its mean depth.
    double mass = 0, moment = 0;
    for (double t = first * std::exp(-step); t > 1e-20; t *= std::exp(-step)) {
      mass += trapezoid(t);
      moment += t * trapezoid(t);
    }
    const double to_second = (moment - mass * depth[0]) / (depth[1] - depth[0]);
    weight[0] += mass - to_second;
    weight[1] += to_second;
    double sum = 0;
    for (const double w : weight) sum += w;
    for (double& w : weight) w /= sum;
  }
};

template <typename T, bool near_correction>
struct ExtendedSourceDiffusion {
  T albedo_squared;    ///< alpha'^2, 0 .. 1
  T flux_weight;       ///< C_E
  T sigma_t_prime;     ///< [1/mm]
  T sigma_tr_squared;  ///< [1/mm^2]
  T gap;               ///< 4 A D: from a source to its image's mirror point [mm]

  explicit ExtendedSourceDiffusion(const Medium<T>& medium) {
    sigma_t_prime = medium.sigma_a + medium.sigma_s_prime;
    const T alpha_prime = medium.sigma_s_prime / sigma_t_prime;
    const T diffusion = (2.0 - alpha_prime) / (3.0 * sigma_t_prime);
    albedo_squared = alpha_prime * alpha_prime;
    flux_weight = exitance_weight_flux(medium.eta);
    sigma_tr_squared = medium.sigma_a / diffusion;
    gap = 4.0 * modified_boundary_a(medium.eta) * diffusion;
  }

  /// E(t, r) kappa(t, r), q = r^2.
  T source_at(const T& q, const T& t) const {
    using std::expm1;
    using std::sqrt;
    const T z_v = t + gap;
    const T poles = pole_evaluate_squared(q, t, sigma_tr_squared) + pole_evaluate_squared(q, z_v, sigma_tr_squared);
    const T fluence = yukawa_gap_squared(q, t, z_v, sigma_tr_squared);
    const T exitance = 0.5 * flux_weight * poles + (1.0 - flux_weight) * fluence;
    if constexpr (!near_correction) return exitance;
    return -expm1(-2.0 * sigma_t_prime * (sqrt(q + t * t) + t)) * exitance;
  }

  /// R_d [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const {
    const T q = r * r;
    return over_depths([&](const T& t) { return source_at(q, t); });
  }

  /// 2 pi int_0^r R_d s ds and its limit; closed without kappa, relative error of the sum 1e-13.
  T cumulative(const T& r) const requires(!near_correction) {
    return over_depths([&](const T& t) {
      const T s = sigma_tr(), z_v = t + gap;
      const T poles = pole_cumulative(r, t, s) + pole_cumulative(r, z_v, s);
      return T(0.5 * flux_weight * poles + (1.0 - flux_weight) * yukawa_gap_cumulative(r, t, z_v, s));
    });
  }
  T total() const requires(!near_correction) {
    using std::exp;
    return over_depths([&](const T& t) {
      const T s = sigma_tr(), poles = 0.5 * (exp(-s * t) + exp(-s * (t + gap)));
      return T(flux_weight * poles + (1.0 - flux_weight) * yukawa_gap_total(t, T(t + gap), s));
    });
  }

  T core_radius() const { return SourceDepths::first / sigma_t_prime; }

 private:
  T sigma_tr() const {
    using std::sqrt;
    return sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(sigma_tr_squared));
  }

  template <typename F>
  T over_depths(const F& f) const {
    static const SourceDepths depths;
    T sum = T(0.0);
    for (std::size_t i = 0; i < SourceDepths::count; ++i) {
      sum += depths.weight[i] * f(T(depths.depth[i] / sigma_t_prime));
    }
    return albedo_squared * sum;
  }
};

template <typename T>
using ExtendedSource = ExtendedSourceDiffusion<T, false>;
template <typename T>
using PhotonBeamDiffusion = ExtendedSourceDiffusion<T, true>;

/// Total of the extended source without kappa, in closed form.
template <typename T>
T extended_source_total(const Medium<T>& medium) {
  using std::exp;
  using std::sqrt;
  const ExtendedSource<T> source(medium);
  const T s = source.sigma_tr_squared == 0.0 ? T(0.0) : T(sqrt(source.sigma_tr_squared));
  const T poles = 0.5 * (1.0 + exp(-s * source.gap));
  const T mean = source.flux_weight * poles + (1.0 - source.flux_weight) * mean_decay(T(s * source.gap));
  return source.albedo_squared * mean / (1.0 + s / source.sigma_t_prime);
}

}  // namespace opaline
