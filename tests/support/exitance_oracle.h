// Radiant exitance by adaptive quadrature in double: an oracle that shares no code with the gather.
// No patches, no moments, no tables, no float: only the profile, the cells and their irradiance.
#pragma once

#include "model/profiles/profile.h"
#include "render/irradiance/irradiance.h"

#include <algorithm>
#include <cmath>

namespace opaline::test {

/// Mean of f over a triangle by Radon's seven-point rule, exact for polynomials of degree five.
template <typename F>
double seven_points(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const F& f) {
  const double root = std::sqrt(15.0);
  double sum = 9.0 / 40 * f((a + b + c) / 3.0);
  for (const double sign : {-1.0, 1.0}) {
    const double near = (6 + sign * root) / 21, far = 1 - 2 * near, weight = (155 + sign * root) / 1200;
    sum += weight * (f(near * (a + b) + far * c) + f(near * (b + c) + far * a) + f(near * (c + a) + far * b));
  }
  return sum;
}

/// Integral of f over a triangle: split in four until the rule agrees with itself to `tolerance` (absolute).
template <typename F>
double integrate_triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, double tolerance, const F& f,
                          int depth = 0) {
  const double area = glm::length(glm::cross(b - a, c - a)) / 2;
  const glm::dvec3 ab = (a + b) / 2.0, bc = (b + c) / 2.0, ca = (c + a) / 2.0;
  const double whole = area * seven_points(a, b, c, f);
  const double parts = area / 4 *
                       (seven_points(a, ab, ca, f) + seven_points(ab, b, bc, f) + seven_points(ca, bc, c, f) +
                        seven_points(bc, ca, ab, f));
  if (depth == 40 || std::abs(whole - parts) <= tolerance) return parts;
  const double quarter = tolerance / 2;  // errors of the parts are not all of one sign
  return integrate_triangle(a, ab, ca, quarter, f, depth + 1) + integrate_triangle(ab, b, bc, quarter, f, depth + 1) +
         integrate_triangle(ca, bc, c, quarter, f, depth + 1) + integrate_triangle(bc, ca, ab, quarter, f, depth + 1);
}

/// Integral over a triangle of a kernel that peaks within `core` of x. The rule's agreement with itself means
/// nothing while a triangle may hide the whole peak between its points, so such a triangle is split first.
template <typename F>
double integrate_peak(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& x, double core,
                      double tolerance, const F& f) {
  const double edge = std::max({glm::length(b - a), glm::length(c - b), glm::length(a - c)});
  if (edge <= glm::length((a + b + c) / 3.0 - x) + core) return integrate_triangle(a, b, c, tolerance, f);
  const glm::dvec3 ab = (a + b) / 2.0, bc = (b + c) / 2.0, ca = (c + a) / 2.0;
  return integrate_peak(a, ab, ca, x, core, tolerance / 2, f) + integrate_peak(ab, b, bc, x, core, tolerance / 2, f) +
         integrate_peak(ca, bc, c, x, core, tolerance / 2, f) + integrate_peak(bc, ca, ab, x, core, tolerance / 2, f);
}

/// B at x: sum over the cells of E of `channel` times the integral of R_d. `tolerance` is per cell and unit of E.
inline double exitance_oracle(const SurfaceCells& cells, const IrradianceField& field, int channel,
                              const Profile& profile, const glm::vec3& x, double tolerance) {
  const glm::dvec3 origin(x);
  const auto reflectance = [&](const glm::dvec3& p) { return profile.evaluate(glm::length(p - origin)); };
  double sum = 0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double e = static_cast<double>(
        field.values[i * static_cast<std::size_t>(field.width()) + static_cast<std::size_t>(channel)]);
    if (e == 0) continue;
    sum += e * integrate_peak(glm::dvec3(cells[i].a), glm::dvec3(cells[i].b), glm::dvec3(cells[i].c), origin,
                              profile.core_radius(), tolerance, reflectance);
  }
  return sum;
}

}  // namespace opaline::test
