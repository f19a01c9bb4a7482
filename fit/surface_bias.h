// What a planar profile of a normal beam leaves out on a given object, as measured: how far a fit with transport itself
// comes out from the truth because the surface is curved or the light is oblique. It is printed beside the result; it
// corrects nothing.
#pragma once

#include "fit/solve.h"

#include <array>
#include <string>

namespace opaline {

/// How the object's visible surface bends and how the light falls on it.
struct SurfaceShape {
  double radius_mm = 0;      ///< 1/median curvature between neighbouring pixels; infinite: flat
  double incidence_deg = 0;  ///< mean angle between the normal and the light over the visible lit points; of a sky 45
};
SurfaceShape surface_shape(const Scene& scene, int material);

/// Relative errors to be expected, per channel.
struct SurfaceBias {
  SurfaceShape shape;
  std::array<double, 3> radius_mfp{}, sigma_a{}, sigma_s_prime{};
  bool side_light = false;  ///< which measurement: lit from the side, or by a beam along the normal
  std::string note;
};

/// Of a fit with transport_table or transport_radiance (nothing is known of the others).
///
/// A beam along the normal of a sphere, seen along it, fitted with transport_radiance: sigma_a is low by 0.77 times the
/// diffusion length l_d = 1/sqrt(3 sigma_a sigma_t') over the radius, sigma_s' right within 4 %: measured at 5, 10, 20
/// and 50 transport mean free paths, alpha' .98, .9 and .7, eta 1.4 (fit.md has the table).
///
/// A sphere lit from the side, fitted with transport_table, is far off at any radius: oblique light stays closer to the
/// surface, and more of it comes back than the profile of a normal beam has. Interpolated in the same grid.
SurfaceBias surface_bias(const SurfaceShape& shape, const Material& material);

}  // namespace opaline
