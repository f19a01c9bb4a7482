#include "fit/starts.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

double radical_inverse(std::uint64_t n, unsigned base) {
  double value = 0, digit = 1.0 / base;
  for (; n; n /= base, digit /= base) value += digit * static_cast<double>(n % base);
  return value;
}

ParameterVector halton_point(const FitProblem& problem, ParameterVector p, int i) {
  const SolveSettings& s = problem.settings();
  const RadialBasis& radial = problem.targets().front().op.radial;
  const double size = radial.radius(radial.size() - 3);
  const std::uint64_t n = 16 + s.seed * 1000 + static_cast<std::uint64_t>(i);
  const double sigma_t = 5 / size * std::pow(200.0, radical_inverse(n, 2));
  const double one_minus_alpha = std::pow(10.0, -0.3 - 3.2 * radical_inverse(n, 3));
  for (int c = 0; c < 3; ++c) {
    if (problem.is_free(c)) p[static_cast<std::size_t>(c)] = std::log(sigma_t * one_minus_alpha);
    if (problem.is_free(c + 3)) p[static_cast<std::size_t>(c) + 3] = std::log(sigma_t * (1 - one_minus_alpha));
  }
  const ParameterBounds& bounds = problem.bounds();
  if (problem.is_free(eta_index))
    p[eta_index] = bounds.eta_min + (bounds.eta_max - bounds.eta_min) * radical_inverse(n, 5);
  return p;
}

}  // namespace

std::vector<ParameterVector> start_points(const FitProblem& problem, const ParameterVector& initial) {
  std::vector<ParameterVector> points{initial};
  for (int i = 1; i < problem.settings().starts; ++i) points.push_back(halton_point(problem, initial, i));
  for (ParameterVector& p : points)
    for (int i = 0; i < parameter_count; ++i)
      if (problem.is_free(i))
        p[static_cast<std::size_t>(i)] =
            std::clamp(p[static_cast<std::size_t>(i)], problem.bounds().lower(i), problem.bounds().upper(i));
  return points;
}

}  // namespace opaline
