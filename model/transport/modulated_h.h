// Chandrasekhar's H function of a half space whose light varies over its surface like exp(i k x): isotropic
// scattering, no boundary, lengths in mean free paths.
//
// A wave in x turns the point kernel exp(-d)/(4 pi d^2) into
//   K(u) = (1/2) int_1^inf exp(-u t) ds/t,   t = sqrt(s^2 + k^2),
// in depth u, still a mixture of falling exponentials: Chandrasekhar's problem with another characteristic function
// (Rybicki 1971). With the source S = albedo (exp(-z/x) + int K(|z - z'|) S dz'),
//   int S exp(-z/y) dz = albedo x y/(x + y) H(x) H(y)
//   H(x) = exp( -(x/pi) int_0^inf ln(1 - albedo atan(q)/q) / (1 + x^2 tau^2) dtau ),   q^2 = tau^2 + k^2
// for complex x and y with positive real parts: x = mu/(1 - i k sin(theta) cos(phi)) belongs to a ray.
//
// k^2 may be negative: light that grows like exp(|k| x), |k| < 1/v0 (asymptotic_decay.h).
#pragma once

#include <complex>
#include <vector>

namespace opaline {

class ModulatedH {
 public:
  /// albedo in (0, 1]; k_squared > -1/v0^2.
  ModulatedH(double albedo, double k_squared);

  /// H(x) - 1, for Re x > 0, without cancellation. Error about 1e-13 of H.
  std::complex<double> minus_one(std::complex<double> x) const;

 private:
  double constant_;                   ///< 1/H(infinity)
  std::vector<double> x_, strength_;  ///< nodes 1/t, and there Psi H times the weight of the rule
};

}  // namespace opaline
