#include "render/transfer/harmonics.h"

#include "model/check.h"
#include "model/conventions.h"
#include "render/transfer/cholesky.h"

#include <cmath>

namespace opaline {
std::vector<double> harmonics(int order, const glm::dvec3& w) {
  OPALINE_CHECK(order >= 1 && order <= highest_order);
  std::vector<double> y(static_cast<std::size_t>(order * order));
  // sin^m t cos(m p) and sin^m t sin(m p) are the parts of (x + i y)^m, so P is taken without its sin^m t, and all is
  // a polynomial of x, y, z.
  double cosine = 1, sine = 0, p_mm = 1, k_mm = 1 / std::sqrt(4 * pi);
  for (int m = 0; m < order; ++m) {
    double p = p_mm, below = 0, k = k_mm * std::sqrt(2.0 * m + 1);
    for (int l = m; l < order; ++l) {
      const auto at = [&](int signed_m) -> double& { return y[static_cast<std::size_t>(l * (l + 1) + signed_m)]; };
      const double scale = m == 0 ? k : std::sqrt(2.0) * k;
      if (m > 0) at(-m) = scale * p * sine;
      at(m) = scale * p * cosine;
      const double next = ((2 * l + 1) * w.z * p - (l + m) * below) / (l - m + 1);
      below = p, p = next;
      k *= std::sqrt((2.0 * l + 3) / (2.0 * l + 1) * (l + 1 - m) / (l + 1 + m));
    }
    p_mm *= 2 * m + 1;
    k_mm /= std::sqrt((2.0 * m + 1) * (2.0 * m + 2));
    const double turned = cosine * w.x - sine * w.y;
    sine = cosine * w.y + sine * w.x, cosine = turned;
  }
  return y;
}

bool harmonic_projection(int order, const std::vector<glm::dvec3>& directions, std::vector<double>& matrix) {
  const auto n = static_cast<std::size_t>(order * order), m = directions.size();
  if (m < n) return false;
  matrix.assign(n * m, 0);
  std::vector<double> normal(n * n, 0.0);
  const double solid_angle = 4 * pi / static_cast<double>(m);
  for (std::size_t j = 0; j < m; ++j) {
    const std::vector<double> y = harmonics(order, directions[j]);
    for (std::size_t i = 0; i < n; ++i) {
      matrix[i * m + j] = solid_angle * y[i];
      for (std::size_t k = 0; k < n; ++k) normal[i * n + k] += solid_angle * y[i] * y[k];
    }
  }
  return solve_cholesky(normal, matrix, n, m);
}

}  // namespace opaline
