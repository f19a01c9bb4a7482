// Real spherical harmonics of a direction, orthonormal over the sphere.
//
// As in Hao and Varshney 2004, section 4.1 (after Sloan et al. 2002): with (x, y, z) = (sin t cos p, sin t sin p, cos
// t)
//   y_l^m = sqrt2 K_l^m cos(m p) P_l^m(cos t)      m > 0
//           sqrt2 K_l^m sin(-m p) P_l^-m(cos t)    m < 0       (K_l^m taken at |m|)
//           K_l^0 P_l^0(cos t)                     m = 0
// with K = sqrt((2l+1)/(4 pi) (l-|m|)!/(l+|m|)!). P here has no Condon-Shortley sign, which the paper leaves open; the
// sign of single functions changes neither a projection's error nor what is reconstructed.
#pragma once

#include <glm/glm.hpp>

#include <vector>

namespace opaline {

inline constexpr int highest_order = 12;

/// The order^2 functions with l < order at a unit vector; function (l, m) at l (l + 1) + m.
std::vector<double> harmonics(int order, const glm::dvec3& w);

/// The order^2 x directions matrix, by rows, that takes a function's values at some directions to the coefficients
/// which reproduce them best (least squares). For more directions than coefficients; false if they don't determine
/// them.
bool harmonic_projection(int order, const std::vector<glm::dvec3>& directions, std::vector<double>& matrix);

}  // namespace opaline
