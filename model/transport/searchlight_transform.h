// The searchlight problem in wave numbers, without chance: the Hankel transform
//   M(k) = 2 pi int_0^inf R_m(r) J_0(k r) r dr
// of the light R_m that leaves an isotropically scattering half space after TWO or more scatterings, for a normal
// pencil beam of unit flux (counted after it has entered) and a smooth Fresnel boundary. Single scattering has a closed
// form: model/single_scattering/half_space.h. Lengths in mean free paths.
//
// Derivation. Let x(w) = mu/(1 - i k sin(theta) cos(phi)) for a ray w, and H the function of modulated_h.h. Light that
// comes up to the boundary is (albedo x/(4 pi mu)) H(x) Y(x), and each part of it that the boundary sends down again,
// F(mu), excites the half space anew (invariance):
//   Y(x) = H(1)/(1 + x) + (albedo/4 pi) int (F(mu')/mu') x'^2 H(x')^2 Y(x')/(x + x') dw'
//   M(k) = (albedo/4 pi) int (1 - F(mu)) x (H(x) Y(x) - 1/(1 + x)) dw
// over the hemisphere. The rays are a product of Gauss rules graded towards what the integrands have: the critical
// cosine, grazing rays outside, and the width 1/k around the normal and around phi = pi/2; the equation is solved by
// GMRES (about five steps).
//
// Radiance instead of exitance: the ray straight up (x = 1, mu = 1) leaves with the radiance
//   (1 - F(1))/eta^2 (albedo/4 pi) H(1) Y(1)
// which conventions.h writes as F_t(1) B/(pi c): M(k) = (c albedo/(4 eta^2)) (H(1) Y(1) - 1/2). Both the beam and the
// view are along the normal, so this too depends on the distance alone.
//
// Relative error at resolution 1.3 (measured against 1.7 and, at k = 0, against h_function.h): 1e-8 for k <= 1,
// 1e-6 at 10, 1e-4 at 100; at eta = 1 1e-9 everywhere.
#pragma once

#include <span>
#include <vector>

namespace opaline {

/// What of the light that leaves.
enum class SearchlightExit {
  exitance,     ///< all of it
  radiance_up,  ///< the radiance along the normal, as the exitance B that a lobe F_t B/(pi c) would need for it
};

/// M for each of the albedos in (0, 1], at one k^2 and one eta >= 1. k_squared > -1/v0^2 for the largest albedo
/// (asymptotic_decay.h), and at least -0.98^2. `resolution` multiplies the number of nodes of every rule. A millisecond
/// an albedo for k < 1, 50 at k = 100.
std::vector<double> searchlight_transform(double k_squared, double eta, std::span<const double> albedos,
                                          double resolution = 1.3, SearchlightExit exit = SearchlightExit::exitance);

}  // namespace opaline
