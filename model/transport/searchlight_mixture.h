// The searchlight problem in space, without chance: the light that leaves an isotropically scattering half space after
// two or more scatterings, as a sum of two-dimensional Yukawa terms,
//   R_m(r) = sum_j w_j K_0(kappa_j r)/(2 pi),   w_j > 0,   kappa_j >= 1/v0
// so that its Hankel transform is sum_j w_j/(k^2 + kappa_j^2). The transform (searchlight_transform.h) is known at 39
// real wave numbers up to 330 and, where 1/v0 allows, at imaginary ones, which weigh the tail; the sum is fitted to it
// by non-negative least squares over kappa^2 = 1/v0^2 + 10^(-9 ... 6). That such a sum exists is not proved, but shown:
// the fit's residual is as small as the error of the transform. It makes R_m positive and falling, with the exact
// exponent of its decay.
//
// Conventions: per flux that has entered, lengths in mean free paths. Add single_scattering_profile
// (model/single_scattering/half_space.h) for all light; of the radiance straight up it is where the beam enters alone,
// with the flux albedo c/(8 eta^2). That radiance is symmetric in light and view, so that its sum has w_j >= 0 for a
// reason: M is a quadratic form of the inverse of k^2 + a positive operator.
//
// Relative error of R_m, from halved spacings, other weights and higher resolution: 2e-5 from r = 0.01 until R_m is
// 1e-10, 1e-4 until 1e-14, 1 % in the tail beyond.
#pragma once

#include "model/transport/searchlight_transform.h"

#include <span>
#include <vector>

namespace opaline {

struct SearchlightMixture {
  struct Term {
    double weight, kappa;
  };
  double decay = 0;         ///< 1/v0
  std::vector<Term> terms;  ///< by rising kappa
  double residual = 0;      ///< largest relative error of the transform, in units of the one expected there

  /// ln R_m(r), r > 0; it doesn't underflow.
  double log_evaluate(double r) const;
  /// 2 pi int_0^inf R_m r dr.
  double total() const;
  /// 2 pi int_inner^outer R_m r dr, 0 <= inner <= outer.
  double flux_between(double inner, double outer) const;
  /// 2 pi int_0^inf R_m J_0(k r) r dr.
  double transform(double k_squared) const;
};

/// One for each albedo in (0, 1], eta >= 1, computed on all threads; the same bits for any number of them.
std::vector<SearchlightMixture> searchlight_mixtures(double eta, std::span<const double> albedos,
                                                     double resolution = 1.3,
                                                     SearchlightExit exit = SearchlightExit::exitance);

}  // namespace opaline
