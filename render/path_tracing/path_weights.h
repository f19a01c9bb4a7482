// One path for all colour channels. A channel walks with its own extinction ("leads"), and every path that it makes
// counts in every channel: with f_c the contribution of the path in channel c and p_h the density with which lead h
// would have made it, one path of every lead gives
//
//   sum over leads of f_c / (sum over h of p_h)           (the balance heuristic, Veach & Guibas 1995)
//
// without bias and without a weight above the number of leads. Channels with the same coefficients are one lead.
#pragma once

#include "render/scene/scene.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {

/// The distinct channels of a material. Coefficients in 1/mm; sigma_s is not reduced.
struct PathChannels {
  int count = 0;
  std::array<int, 3> of{};  ///< which lead serves R, G, B
  std::array<double, 3> sigma_s{}, sigma_t{};
  double smallest_sigma_t = 0;

  explicit PathChannels(const Material& material) {
    for (int c = 0; c < 3; ++c) {
      const double s = material.sigma_s_prime[c] / (1 - material.g), t = s + material.sigma_a[c];
      int k = 0;
      while (k < count && !(sigma_s[at(k)] == s && sigma_t[at(k)] == t)) ++k;
      of[at(c)] = k;
      if (k < count) continue;
      sigma_s[at(k)] = s;
      sigma_t[at(k)] = t;
      ++count;
    }
    smallest_sigma_t = *std::min_element(sigma_t.begin(), sigma_t.begin() + count);
  }
  static std::size_t at(int k) { return static_cast<std::size_t>(k); }
};

/// f_c and p_h of a path so far, both divided by the sum of the p_h.
class PathWeights {
 public:
  PathWeights(const PathChannels& channels, int lead) : channels_(&channels), lead_(PathChannels::at(lead)) {
    value_.fill(1.0 / channels.count);
    density_.fill(1.0 / channels.count);
  }

  double lead_extinction() const { return channels_->sigma_t[lead_]; }

  void fly(double length) {
    // The lead's own transmittance is left out of all: it cancels, and nothing underflows.
    for_each([&](std::size_t k) {
      const double t = std::exp(-(channels_->sigma_t[k] - channels_->sigma_t[lead_]) * length);
      value_[k] *= t;
      density_[k] *= t;
    });
    normalise();
  }
  void scatter() {
    for_each([&](std::size_t k) {
      value_[k] *= channels_->sigma_s[k];
      density_[k] *= channels_->sigma_t[k];
    });
    normalise();
  }
  /// Ends a path of little weight by chance, and pays the others for it. The weight at which that begins is a
  /// compromise between long paths and noisy ones.
  bool survives(double xi) {
    constexpr double threshold = 0.5;
    const double survival = most() * channels_->count / threshold;
    if (survival >= 1) return true;
    if (!(xi < survival)) return false;
    for_each([&](std::size_t k) { value_[k] /= survival; });
    return true;
  }

  /// The largest of the values.
  double most() const { return *std::max_element(value_.begin(), value_.begin() + channels_->count); }
  double smallest_extinction() const { return channels_->smallest_sigma_t; }

  /// Weights in R, G, B of light that comes over a further `length` of the medium.
  Rgb over(double length) const {
    std::array<double, 3> w{};
    for_each([&](std::size_t k) { w[k] = value_[k] * std::exp(-channels_->sigma_t[k] * length); });
    return {w[PathChannels::at(channels_->of[0])], w[PathChannels::at(channels_->of[1])],
            w[PathChannels::at(channels_->of[2])]};
  }

 private:
  template <typename F>
  void for_each(F&& f) const {
    for (std::size_t k = 0; k < PathChannels::at(channels_->count); ++k) f(k);
  }
  void normalise() {
    double sum = 0;
    for_each([&](std::size_t k) { sum += density_[k]; });
    for_each([&](std::size_t k) {
      value_[k] /= sum;
      density_[k] /= sum;
    });
  }

  const PathChannels* channels_;
  std::size_t lead_;
  std::array<double, 3> value_, density_;
};

}  // namespace opaline
