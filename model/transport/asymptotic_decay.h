// How fast light falls far from any source in an isotropically scattering medium: like exp(-k d), where k = 1/v0 is
// the root in [0, 1] of albedo artanh(k)/k = 1 (Case & Zweifel 1967). Lengths in mean free paths; for an albedo
// reduced by similarity, alpha', in transport mean free paths. Diffusion theory's k^2 = 3 (1 - albedo) is its limit
// for albedo -> 1; without scattering k = 1.
#pragma once

#include "model/scalar.h"

#include <cmath>

namespace opaline {

namespace asymptotic_decay_detail {

/// (artanh(k)/k - 1)/k^2 and its derivative by k^2, at k^2 = w < 1.
inline double excess(double w) {
  if (w > 0.01) return (std::atanh(std::sqrt(w)) / std::sqrt(w) - 1) / w;
  double sum = 0;
  for (int n = 9; n >= 1; --n) sum = 1 / (2.0 * n + 1) + w * sum;
  return sum;
}
/// d(artanh(k)/k)/dw.
inline double slope(double w) {
  if (w > 0.01) return (1 / (1 - w) - 1 - w * excess(w)) / (2 * w);
  double sum = 0;
  for (int n = 9; n >= 1; --n) sum = n / (2.0 * n + 1) + w * sum;
  return sum;
}

/// k^2 to about 1e-9 relative or 1e-16 absolute.
inline double first_guess(double absorbed) {
  if (absorbed < 1e-9) return 3 * absorbed;
  double low = 0, high = 1;
  for (int i = 0; i < 55; ++i) {
    const double k = 0.5 * (low + high), w = k * k;
    ((1 - absorbed) * w * excess(w) < absorbed ? low : high) = k;
  }
  return 0.25 * (low + high) * (low + high);
}

}  // namespace asymptotic_decay_detail

/// k^2 for absorbed = 1 - albedo in [0, 1]. Relative error below 1e-14 for albedo >= 0.06; below, 1 - k < 1e-14 and the
/// result is 1. It is smooth up to absorbed = 0 (where k itself has an infinite derivative): dual numbers get the exact
/// derivative.
template <typename T>
T asymptotic_decay_squared(const T& absorbed) {
  using namespace asymptotic_decay_detail;
  const double share = value_of(absorbed);
  if (share > 0.94) return T(1.0);
  const double w = first_guess(share);
  // A step of Newton's method from the root found in double carries the derivatives, and the last digits.
  const T residual = (1.0 - absorbed) * (w * excess(w)) - absorbed;
  return w - residual / ((1.0 - share) * slope(w));
}

}  // namespace opaline
