// The rule of patches.h written out in double, for the tests of the vector code that applies it.
#pragma once

#include "render/irradiance/cluster_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace opaline::test {

/// The moments of five random points within `size` of their centroid; any() is in [-1, 1].
template <typename Any>
void give_moments(ClusterNode& node, float size, Any&& any) {
  constexpr int count = 5;
  constexpr float factorial[] = {1, 1, 2, 6};
  glm::vec3 delta[count], mean(0);
  for (glm::vec3& d : delta) d = size * glm::vec3(any(), any(), any()), mean += d / static_cast<float>(count);
  float fourth = 0;
  for (glm::vec3& d : delta) {
    d -= mean;
    node.extent.radius = std::max(node.extent.radius, glm::length(d));
    const float square = glm::dot(d, d), part = 1.0f / count;
    node.extent.trace += part * square;
    fourth += part * square * square;
    int k = 0;
    for (int a = 0; a < 3; ++a)
      for (int b = a; b < 3; ++b) node.covariance[k++] += part * d[a] * d[b];
    for (int m = 0; m <= 3; ++m)
      for (int c = 0; c <= m; ++c)
        node.third[monomial(m, c)] += part * 6 / (factorial[3 - m] * factorial[m - c] * factorial[c]) *
                                      std::pow(d.x, 3.0f - static_cast<float>(m)) *
                                      std::pow(d.y, static_cast<float>(m - c)) * std::pow(d.z, static_cast<float>(c));
  }
  node.extent.deviation = std::sqrt(std::max(fourth - node.extent.trace * node.extent.trace, 0.0f));
}

/// The two-point rule for one patch, written out: two values of q and their weights that have the mean q0, the variance
/// and the third central moment of q = |D - delta|^2.
struct TwoPointRule {
  double near, far, share_of_near, spread;
  glm::dvec3 d;
};

/// E (D . delta)^3 and E (D . delta) |delta|^2, from the coefficients of the cubic form.
inline std::pair<double, double> third_moments(const ClusterNode& node, const glm::dvec3& d) {
  double cubic = 0, radial = 0;
  for (int m = 0; m <= 3; ++m)
    for (int c = 0; c <= m; ++c) {
      const int power[3] = {3 - m, m - c, c};
      const double k = static_cast<double>(node.third[monomial(m, c)]);
      cubic += k * std::pow(d.x, power[0]) * std::pow(d.y, power[1]) * std::pow(d.z, power[2]);
      for (int axis = 0; axis < 3; ++axis)  // a sixth of the Laplacian, along D
        if (power[axis] >= 2)
          for (int along = 0; along < 3; ++along)
            if (power[along] - (along == axis ? 2 : 0) == 1)
              radial += k * power[axis] * (power[axis] - 1) / 6 * d[along];
    }
  return {cubic, radial};
}

inline TwoPointRule two_point_rule(const ClusterNode& node, const glm::vec3& position) {
  const float* c = node.covariance;
  const glm::dmat3 covariance(c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5]);
  const glm::dvec3 d = glm::dvec3(position) - glm::dvec3(node.centroid);
  const double trace = static_cast<double>(node.extent.trace), along = glm::dot(d, covariance * d);
  const auto [cubic, radial] = third_moments(node, d);
  const double variance = 4 * along - 4 * radial + static_cast<double>(node.extent.deviation * node.extent.deviation);
  const double gamma = (4 * trace * along - 8 * cubic) / variance, q0 = glm::dot(d, d) + trace;
  const double spread = std::sqrt(variance + gamma * gamma / 4);
  const double radius = static_cast<double>(node.extent.radius), reach = glm::length(d) + radius,
               gap = std::max(glm::length(d) - radius, 0.0);
  return {std::max(q0 + gamma / 2 - spread, gap * gap), std::min(q0 + gamma / 2 + spread, reach * reach),
          0.5 + gamma / (4 * spread), spread, d};
}

}  // namespace opaline::test
