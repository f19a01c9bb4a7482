// The inverse Hankel transform of a diffusion formula, as a sum of heat kernels with weights that no oscillating
// integral is needed for.
//
//   R(r) = 1/(2 pi) int_0^inf R~(k) J_0(k r) k dk = int_0^inf phi(t) exp(-r^2/(4t))/(4 pi t) dt
//
// where phi is the inverse Laplace transform of R~ as a function of p = k^2: the reflected flux over diffusion time (an
// area). phi >= 0, so R is positive and falls with r; nothing rings. phi(t) comes from the cotangent contour of
// Dingfelder & Weideman 2015 with 28 nodes around p = -decay^2, the singularity of R~ that lies furthest to the right:
// so phi keeps its relative accuracy (about 1e-13) however far it has fallen. The integral is a trapezoid rule in u,
// decay sqrt(t) = log(1 + exp(b u))/b: steps in log t where R is algebraic, in sqrt(t) where it decays, so that R keeps
// 1e-11 until it has fallen by exp(-300). The sum's own transform, sum w exp(-t p), stands against the closed one as a
// certificate.
//
// Templated on the scalar; derived here, the superposition of Gaussians after d'Eon & Irving 2011.
#pragma once

#include "model/conventions.h"
#include "model/profiles/complex.h"
#include "model/scalar.h"

#include <array>
#include <vector>

namespace opaline {

/// w exp(-r^2/(4 t))/(4 pi t): flux w, t [mm^2].
template <typename T>
struct HeatKernel {
  T weight;
  double t;
};

/// The upper half of the contour: phi(t) = 1/t sum Im(weight F(point/t)).
struct LaplaceContour {
  static constexpr int nodes = 28, half = nodes / 2;
  std::array<Complex<double>, half> point, weight;

  LaplaceContour() {
    for (int i = 0; i < half; ++i) {
      const double angle = (2 * i + 1) * pi / nodes, a = 0.6407 * angle, cot = std::cos(a) / std::sin(a);
      const Complex<double> at(0.5017 * angle * cot - 0.6122, 0.2645 * angle);
      const Complex<double> slope(0.5017 * (cot - a * (1 + cot * cot)), 0.2645);
      point[static_cast<std::size_t>(i)] = at * static_cast<double>(nodes);
      weight[static_cast<std::size_t>(i)] = exp(at * static_cast<double>(nodes)) * slope * 2.0;
    }
  }
};

/// The trapezoid rule: t and the weight h t'(u)/t.
struct HeatNode {
  double t, weight;
};

/// Nodes from `first` on; by log t alone if nothing decays, then to 1e24 times as far.
inline std::vector<HeatNode> heat_nodes(double first, double decay_squared) {
  constexpr double step = 0.25, bend = 0.6, far = 13;  // exp(-far^2) of phi is where it ends
  std::vector<HeatNode> nodes;
  if (first * decay_squared < 1e-24) {
    for (double t = first; t < 1e24 * first; t *= std::exp(2 * bend * step)) nodes.push_back({t, 2 * bend * step});
    return nodes;
  }
  const double decay = std::sqrt(decay_squared);
  for (double u = std::log(std::expm1(bend * decay * std::sqrt(first))) / bend;; u += step) {
    const double y = std::log1p(std::exp(bend * u)) / bend, t = y * y / decay_squared;
    if (y > far) return nodes;
    nodes.push_back({t, step * 2 * -std::expm1(-bend * y) / y});
  }
}

/// The kernels of R~ given as transform(p, t), p complex with a real part > -decay_squared; it may differ from R~ by a
/// constant of its own for every t, which has no phi.
///   depth          distance of the source from the surface the light leaves by [mm]: phi is negligible for t <
///   depth^2/180 decay_squared  [1/mm^2] >= 0 total          R~(0); what lies beyond the largest kernel, if
///   anything does, goes there
template <typename T, typename Transform>
std::vector<HeatKernel<T>> heat_kernels(const Transform& transform, double depth, double decay_squared, double total) {
  static const LaplaceContour contour;
  std::vector<HeatKernel<T>> kernels;
  double left = total;
  for (const auto& [t, step] : heat_nodes(depth * depth / 180, decay_squared)) {
    T sum = T(0.0);
    for (int i = 0; i < LaplaceContour::half; ++i) {
      const Complex<double>&z = contour.point[static_cast<std::size_t>(i)],
            &w = contour.weight[static_cast<std::size_t>(i)];
      const Complex<T> f = transform(Complex<T>(T(z.re / t - decay_squared), T(z.im / t)), t);
      sum += w.re * f.im + w.im * f.re;
    }
    const T weight = step * std::exp(-decay_squared * t) * sum;
    if (!(weight > 0.0)) continue;  // rounding where phi is negligible
    kernels.push_back({weight, t});
    left -= value_of(weight);
  }
  if (decay_squared == 0 && left > 0 && !kernels.empty()) kernels.push_back({T(left), 10 * kernels.back().t});
  return kernels;
}

/// R(r) [1/mm^2], and the flux within r.
template <typename T>
T evaluate_kernels(const std::vector<HeatKernel<T>>& kernels, const double r) {
  T sum = T(0.0);
  for (const HeatKernel<T>& kernel : kernels) {
    const double exponent = r * r / (4 * kernel.t);
    if (exponent < 745) sum += kernel.weight * (std::exp(-exponent) / (4 * pi * kernel.t));
  }
  return sum;
}

inline double kernels_within(const std::vector<HeatKernel<double>>& kernels, double r) {
  double sum = 0;
  for (const HeatKernel<double>& kernel : kernels) sum -= kernel.weight * std::expm1(-r * r / (4 * kernel.t));
  return sum;
}

}  // namespace opaline
