// Quadrature over the rays that meet the surface of a half space from inside, weighted by Fresnel's formulas, for light
// that varies over the surface like exp(i k x). Internal to model/transport; see searchlight_transform.h.
#pragma once

#include <complex>
#include <vector>

namespace opaline {

/// A ray stands for itself and its mirror image, whose x is the conjugate: int f(x) dw = sum of weight (f(x) + f(x*)).
struct RayRule {
  std::vector<std::complex<double>> x;  ///< mu/(1 - i k sin(theta) cos(phi))
  std::vector<double> reflected;        ///< weight F(mu)/mu
  std::vector<double> transmitted;      ///< weight (1 - F(mu))
};

/// eta >= 1; k_squared may be negative, > -1.
RayRule make_ray_rule(double k_squared, double eta, double resolution);

}  // namespace opaline
