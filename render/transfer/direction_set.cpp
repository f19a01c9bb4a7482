#include "render/transfer/direction_set.h"

#include "model/check.h"
#include "model/conventions.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Four = std::array<double, 4>;

/// Minimises sum w_k^2 / s_k with sum w_k = 1 and sum w_k p_k = 0: w_k = s_k (a + b . p_k). False if the points are on
/// one line, or so nearly that weights become large.
bool linear_weights(const std::array<glm::dvec2, 4>& p, const Four& s, Four& w) {
  glm::dmat3 m(0.0);
  for (std::size_t k = 0; k < 4; ++k) {
    const glm::dvec3 row(1, p[k]);
    m += s[k] * glm::outerProduct(row, row);
  }
  const double determinant = glm::determinant(m);
  if (!(std::abs(determinant) > 1e-12 * m[0][0] * m[1][1] * m[2][2])) return false;
  const glm::dvec3 ab = glm::inverse(m) * glm::dvec3(1, 0, 0);
  for (std::size_t k = 0; k < 4; ++k) w[k] = s[k] * glm::dot(ab, glm::dvec3(1, p[k]));
  return *std::min_element(w.begin(), w.end()) > -0.5;
}

glm::dvec3 any_tangent(const glm::dvec3& w) {
  return glm::normalize(glm::cross(w, std::abs(w.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0)));
}

}  // namespace

DirectionSet::DirectionSet(int count) {
  OPALINE_CHECK(count >= fewest);
  const double golden_angle = pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z),
                 phi = std::remainder(i * golden_angle, 2 * pi);
    directions_.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
  }
}

std::array<std::uint32_t, 4> DirectionSet::nearest(const glm::dvec3& w) const {
  std::array<std::uint32_t, 4> best{};
  Four cosine{-2, -2, -2, -2};
  for (std::uint32_t i = 0; i < directions_.size(); ++i) {
    const double c = glm::dot(directions_[i], w);
    if (c <= cosine[3]) continue;
    std::size_t k = 3;
    for (; k > 0 && cosine[k - 1] < c; --k) cosine[k] = cosine[k - 1], best[k] = best[k - 1];
    cosine[k] = c, best[k] = i;
  }
  return best;
}

std::array<DirectionWeight, 4> DirectionSet::around(const glm::dvec3& w) const {
  const std::array<std::uint32_t, 4> found = nearest(w);
  const glm::dvec3 s = any_tangent(w), t = glm::cross(w, s);
  std::array<glm::dvec2, 4> p;
  Four closeness, weights;
  const double spacing = std::sqrt(4 * pi / static_cast<double>(size()));
  for (std::size_t k = 0; k < 4; ++k) {
    const glm::dvec3& d = directions_[found[k]];
    p[k] = glm::dvec2(glm::dot(d, s), glm::dot(d, t)) / (glm::dot(d, w) * spacing);
    closeness[k] = 1 / (glm::dot(p[k], p[k]) + 1e-12);
  }
  if (!linear_weights(p, closeness, weights)) {
    const double sum = closeness[0] + closeness[1] + closeness[2] + closeness[3];
    for (std::size_t k = 0; k < 4; ++k) weights[k] = closeness[k] / sum;
  }
  std::array<DirectionWeight, 4> result;
  for (std::size_t k = 0; k < 4; ++k) result[k] = {found[k], weights[k]};
  return result;
}

}  // namespace opaline
