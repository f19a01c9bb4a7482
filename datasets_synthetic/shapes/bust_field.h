// The bust as a field: negative inside, about the distance to the surface in mm near it. The frame
// is that of a grown-up's head in mm: +y up, +z forward, eyes near y = 0, crown at y = 118, the cut
// through the chest at y = -215. Symmetric in x.
#pragma once

#include "datasets_synthetic/shapes/zero_set.h"

namespace opaline {

inline constexpr double bust_crown = 118, bust_base = -215;        ///< y of top and bottom [mm]
inline constexpr double bust_height = bust_crown - bust_base;      ///< [mm]
inline constexpr double bust_ear_thickness = 0.012 * bust_height;  ///< of the ear's plate [mm]

double bust_field(const glm::dvec3& p);

/// A box that holds the zero set with room to spare.
Box bust_bounds();

/// The place of the left ear where its plate has no relief: middle and normal, in the frame above.
struct EarProbe {
  glm::dvec3 centre, normal;
};
EarProbe bust_ear_probe();

}  // namespace opaline
