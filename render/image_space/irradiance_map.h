// The irradiance image of one object in one view: what samples on a tangent plane are projected into.
//
// A texel holds the plane of the surface in its pixel and the irradiance there, weighted for the change of variables
// from the tangent plane to the surface:
//
//   J = dA_p / dA_p' = (cos a' / cos a) (d^2 / d'^2) = G(p) / G(p'),   G = d^2 / cos a     (orthographic: 1 / cos a)
//
// p' is a sample on the tangent plane, p the surface point behind it, d their distances from the centre of
// projection and a the angles between their normals and the ray. G(p) is multiplied into the irradiance; G(p') needs
// no texel. Mertens et al. 2003 print the inverse of J (between their eqs. 8 and 9).
#pragma once

#include "render/image_space/projection.h"
#include "render/irradiance/view_irradiance.h"

#include <vector>

namespace opaline {

/// Only the rectangle that the object covers is stored; the projection's cx, cy count from its corner.
struct IrradianceMap {
  Projection projection;
  int width = 0, height = 0;
  int channels = 1;           ///< of the irradiance, 1 or 3
  std::vector<float> texels;  ///< stride() floats each: depth, its slopes along film x and y, E G per channel, padding
  bool lit = false;           ///< is there any light on it?

  int stride() const { return channels == 1 ? 4 : 8; }
  static constexpr float off_object = -1;  ///< E G of a texel that doesn't see the object
};

/// A surface seen at a grazing angle is taken to be seen at this cosine: no texel stands for more than 50 times the
/// area it covers.
inline constexpr float min_texel_cosine = 0.02f;

/// weighted: E times G(p); else E alone (the Jacobian left out).
IrradianceMap make_irradiance_map(const Scene& scene, const GBuffer& view, const ViewIrradiance& irradiance, int object,
                                  bool weighted);

}  // namespace opaline
