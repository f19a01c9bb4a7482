// A profile as a sum of Gaussians (d'Eon & Luebke 2007, "Advanced Techniques for Realistic Real-Time Skin
// Rendering"), for separable blurs and for export to engines that take one.
//
//   R(r) = sum_k w_k exp(-r^2/(2 v_k)) / (2 pi v_k),   2 pi int_0^inf R r dr = sum_k w_k
//
// Weights w_k >= 0 are shares of the flux, variances v_k [mm^2] a geometric series. Units and normalisation:
// conventions.h.
#pragma once

#include "model/profiles/profile.h"

#include <array>
#include <vector>

namespace opaline {

struct Gaussian {
  double weight;    ///< flux
  double variance;  ///< per axis [mm^2]
};

struct GaussianSum {
  std::vector<Gaussian> terms;  ///< by rising variance; terms of weight 0 are left out
  double flux_error = 0;        ///< int |R - profile| 2 pi r dr / total: the share of light at a wrong radius
  double left_out = 0;          ///< the range of variances that was taken: the share of flux left out at either end
  double worst_relative = 0;    ///< max |R/profile - 1| over the radii that hold the middle 98 % of the flux

  double evaluate(double r) const;
  double total() const;
  double cumulative(double r) const;
  /// Radius for uniform xi in [0, 1): a term by its weight, then its closed inverse, reusing xi.
  double sample(double xi) const;
};

/// Fits at most `terms` Gaussians (2 to 64) by non-negative least squares in the flux per log r, the total kept to
/// 1e-6. The range of the variances is the best of seven, between radii that hold 0.2 to 20 % and 99.8 to 80 % of the
/// flux. No terms if the total is 0. Typical flux_error with 4, 6, 8, 12 terms (alpha' 0.95, eta 1.3): standard dipole
/// 2.9, 0.6, 0.2, 0.01 %; photon beam diffusion 5.4, 1.8, 0.7, 0.2 %; normalised diffusion 12, 4.7, 2.4, 0.5 %. Beyond
/// about 16 terms the problem is ill-conditioned and little is gained.
GaussianSum fit_gaussian_sum(const Profile& profile, int terms);

/// The same with a given range, without the stated errors: smooth in the profile wherever the terms stay the same.
GaussianSum fit_gaussian_sum(const Profile& profile, int terms, double left_out);

}  // namespace opaline
