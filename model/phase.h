// Phase functions: the density per solid angle of the scattered direction, integral over the sphere 1.
//
// cos_theta is between the directions of travel before and after, so 1 is straight on. g in (-1, 1) is the mean
// cosine. Units 1/sr. Templated on the scalar; nothing fails.
#pragma once

#include "model/conventions.h"

#include <cmath>

namespace opaline {

/// Henyey & Greenstein 1941: (1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^(3/2)); mean cosine g, moments g^n.
template <typename T>
T henyey_greenstein(const T& cos_theta, const T& g) {
  using std::sqrt;
  const T d = (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cos_theta);  // the printed sum without its cancellation
  return (1.0 - g) * (1.0 + g) / (4.0 * pi * d * sqrt(d));
}

/// The cosine below which a share xi in [0, 1] of Henyey & Greenstein's light goes; its density is the value above.
/// The usual form (1 + g^2 - ((1 - g^2)/(1 + g s))^2)/(2 g), s = 2 xi - 1, brought to one that has no special case at
/// g = 0 and cancels nothing in the forward peak. No branches, no constants wider than T: loops over floats vectorise.
/// Within a few roundings times 1/(1 - |g|), by which it may also leave [-1, 1].
template <typename T>
T sample_henyey_greenstein(const T& xi, const T& g) {
  const T one(1.0), two(2.0);
  const T d = (one - g) + two * g * xi, ratio = (one - g) / d;
  return one - two * (one - xi) * (one + g * xi) * ratio * ratio;
}

/// Schlick's ellipse (Blasi, Le Saec & Schlick 1993) in the sign of HG: (1 - k^2) / (4 pi (1 - k cos)^2), k in (-1, 1).
template <typename T>
T schlick_phase(const T& cos_theta, const T& k) {
  const T d = (1.0 - k) + k * (1.0 - cos_theta);
  return (1.0 - k) * (1.0 + k) / (4.0 * pi * d * d);
}

/// The cosine below which a share xi of Schlick's light goes.
template <typename T>
T sample_schlick_phase(const T& xi, const T& k) {
  const T one(1.0), s = T(2.0) * xi - one;
  return (s + k) / (one + k * s);
}

/// The k commonly used to imitate HG of mean cosine g: 1.55 g - 0.55 g^3 (Pharr & Humphreys 2004). Its own mean
/// cosine is schlick_mean_cosine(k), which differs from g by up to 0.08.
template <typename T>
T schlick_k(const T& g) {
  return g * (1.55 - 0.55 * g * g);
}

/// Mean cosine of Schlick's phase function: 1/k - (1 - k^2)/(2 k^2) log((1+k)/(1-k)), for small k by its series
/// 2 sum k^(2n+1)/((2n+1)(2n+3)).
template <typename T>
T schlick_mean_cosine(const T& k) {
  using std::abs;
  using std::log;
  if (abs(k) >= 0.5) return 1.0 / k - (1.0 - k) * (1.0 + k) / (2.0 * k * k) * log((1.0 + k) / (1.0 - k));
  T power = 2.0 * k, sum = power / 3.0;
  for (double n = 1;; ++n) {
    power *= k * k;
    const T term = power / ((2 * n + 1) * (2 * n + 3));
    sum += term;
    if (sum + (2 * n + 1) * 16.0 * term == sum) return sum;  // the factor covers the rest, and a derivative
  }
}

}  // namespace opaline
