// Random numbers by name: a stream for every (seed, pixel, path), so that a picture does not depend on who draws when.
#pragma once

#include "model/conventions.h"
#include "model/phase.h"
#include "model/transport/split_mix.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace opaline {

class RandomStream {
 public:
  RandomStream(std::initializer_list<std::uint64_t> name) {
    for (const std::uint64_t part : name) mix_.state = SplitMix{mix_.state + part}();
  }
  std::uint64_t bits() { return mix_(); }
  /// In (0, 1), never an end.
  double operator()() { return (static_cast<double>(bits() >> 11) + 0.5) * 0x1p-53; }

 private:
  SplitMix mix_{0};
};

/// A direction at the given cosine from `axis` (unit), azimuth 2 pi xi.
inline glm::dvec3 direction_around(const glm::dvec3& axis, double cosine, double xi) {
  const glm::dvec3 helper = std::abs(axis.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 s = glm::normalize(glm::cross(axis, helper)), t = glm::cross(axis, s);
  const double sine = std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine))), phi = 2 * pi * xi;
  return glm::normalize(sine * std::cos(phi) * s + sine * std::sin(phi) * t + cosine * axis);
}

/// Direction of travel after scattering by Henyey & Greenstein.
inline glm::dvec3 scattered(const glm::dvec3& direction, double g, RandomStream& random) {
  const double cosine = std::clamp(sample_henyey_greenstein(random(), g), -1.0, 1.0);
  return direction_around(direction, cosine, random());
}

}  // namespace opaline
