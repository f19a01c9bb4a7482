#include "model/transport/modulated_h.h"

#include "model/check.h"
#include "model/conventions.h"

#include <cmath>

namespace opaline {
namespace {

/// The dispersion function 1 - albedo atan(q)/q at the wave number q^2 > -1, without cancellation.
double dispersion(double albedo, double q_squared) {
  double missed = 0;  // 1 - atan(q)/q
  if (std::abs(q_squared) > 0.01) {
    const double q = std::sqrt(std::abs(q_squared));
    missed = 1 - (q_squared > 0 ? std::atan(q) : std::atanh(q)) / q;
  } else {
    for (int n = 8; n >= 1; --n) missed = q_squared * (1 / (2.0 * n + 1) - missed);
  }
  return 1 - albedo + albedo * missed;
}

/// The integral in H's exponent, by the trapezoid rule in log tau: its singularities in the log are pi/2 away.
class Exponent {
 public:
  Exponent(double albedo, double k_squared) {
    constexpr double step = 0.2;
    for (double y = -45; y < 60; y += step) {
      const double tau = std::exp(y);
      tau_squared_.push_back(tau * tau);
      weight_.push_back(step * tau * std::log(dispersion(albedo, tau * tau + k_squared)));
    }
  }

  double h(double x) const {
    double sum = 0;
    for (std::size_t i = 0; i < weight_.size(); ++i) sum += weight_[i] / (1 + x * x * tau_squared_[i]);
    return std::exp(-x / pi * sum);
  }

 private:
  std::vector<double> tau_squared_, weight_;
};

}  // namespace

ModulatedH::ModulatedH(double albedo, double k_squared) : constant_(std::sqrt(dispersion(albedo, k_squared))) {
  OPALINE_CHECK(albedo > 0 && albedo <= 1 && k_squared > -1);
  const Exponent exponent(albedo, k_squared);
  // s = 1/m, m from 0 to 1: ds/t^2 = dm/(1 + k^2 m^2). The tanh-sinh rule is exact in spite of H's x log x.
  constexpr double step = 0.05;
  for (int i = -60; i <= 60; ++i) {
    const double y = i * step, e = std::exp(-pi * std::sinh(std::abs(y))), near = e / (1 + e);
    const double m = i < 0 ? near : 1 - near, weight = step * pi * std::cosh(y) * e / ((1 + e) * (1 + e));
    const double spread = 1 + k_squared * m * m, x = m / std::sqrt(spread);
    x_.push_back(x);
    strength_.push_back(0.5 * albedo * weight / spread * exponent.h(x));
  }
}

std::complex<double> ModulatedH::minus_one(std::complex<double> x) const {
  // 1/H = 1 - x int Psi H/(x + x') dx' = 1/H(infinity) + int x' Psi H/(x + x') dx'.
  std::complex<double> lost = 0, inverse = constant_;
  for (std::size_t j = 0; j < x_.size(); ++j) {
    const std::complex<double> term = strength_[j] / (x + x_[j]);
    lost += term;
    inverse += x_[j] * term;
  }
  return x * lost / inverse;
}

}  // namespace opaline
