#include "render/transfer/direction_set.h"

#include "model/check.h"
#include "model/conventions.h"
#include "render/transfer/cholesky.h"

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

DirectionSet::DirectionSet(int count, DirectionInterpolation interpolation) : interpolation_(interpolation) {
  OPALINE_CHECK(count >= fewest);
  const double golden_angle = pi * (3 - std::sqrt(5.0));
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z),
                 phi = std::remainder(i * golden_angle, 2 * pi);
    directions_.emplace_back(r * std::cos(phi), r * std::sin(phi), z);
  }
}

template <std::size_t Count>
std::array<std::uint32_t, Count> DirectionSet::nearest(const glm::dvec3& w) const {
  std::array<std::uint32_t, Count> best{};
  std::array<double, Count> cosine;
  cosine.fill(-2);
  for (std::uint32_t i = 0; i < directions_.size(); ++i) {
    const double c = glm::dot(directions_[i], w);
    if (c <= cosine[Count - 1]) continue;
    std::size_t k = Count - 1;
    for (; k > 0 && cosine[k - 1] < c; --k) cosine[k] = cosine[k - 1], best[k] = best[k - 1];
    cosine[k] = c, best[k] = i;
  }
  return best;
}

std::vector<DirectionWeight> DirectionSet::around(const glm::dvec3& w) const {
  return interpolation_ == DirectionInterpolation::four ? linear(w) : quadratic(w);
}

std::vector<DirectionWeight> DirectionSet::linear(const glm::dvec3& w) const {
  const std::array<std::uint32_t, 4> found = nearest<4>(w);
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
  std::vector<DirectionWeight> result;
  for (std::size_t k = 0; k < 4; ++k) result.push_back({found[k], weights[k]});
  return result;
}

std::vector<DirectionWeight> DirectionSet::quadratic(const glm::dvec3& w) const {
  const std::array<std::uint32_t, 12> found = nearest<12>(w);
  const glm::dvec3 s = any_tangent(w), t = glm::cross(w, s);
  const auto angle = [&](std::uint32_t i) { return std::acos(std::clamp(glm::dot(directions_[i], w), -1.0, 1.0)); };
  const double furthest = angle(found.back());
  std::array<std::array<double, 6>, 12> terms;
  std::array<double, 12> closeness;
  std::vector<double> normal(36, 0.0), value = {1, 0, 0, 0, 0, 0};
  for (std::size_t k = 0; k < 12; ++k) {
    const glm::dvec2 along(glm::dot(directions_[found[k]], s), glm::dot(directions_[found[k]], t));
    const double place = angle(found[k]) / furthest, sine = glm::length(along);
    const glm::dvec2 p = sine > 0 ? along * (place / sine) : along;
    terms[k] = {1, p.x, p.y, p.x * p.x, p.x * p.y, p.y * p.y};
    closeness[k] = std::pow(1 - place * place, 2) / (place * place + 1e-9);
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = 0; j < 6; ++j) normal[6 * i + j] += closeness[k] * terms[k][i] * terms[k][j];
  }
  if (!solve_cholesky(normal, value, 6, 1)) return linear(w);
  std::vector<DirectionWeight> result;
  for (std::size_t k = 0; k < 12; ++k) {
    double weight = 0;
    for (std::size_t i = 0; i < 6; ++i) weight += closeness[k] * terms[k][i] * value[i];
    result.push_back({found[k], weight});
  }
  return result;
}

}  // namespace opaline
