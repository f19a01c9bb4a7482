// The materials that sample sets are made for. A homogeneous object has its own; a textured one has a few
// representatives of what its maps hold. At a point of a textured object the samples are those of the representative
// nearest to the point's material, and the profile is the point's own: which samples are drawn decides the noise, not
// the mean.
#pragma once

#include "render/image_space/sample_set.h"

namespace opaline {

struct SampledMaterial {
  Material material;
  ChannelProfiles profiles;
  SampleSets importance, combined;  ///< without and with the uniform set; either is empty if it is never used
};

/// How far apart two materials are: the largest |ln| of the ratio of any coefficient, those below 1e-4 / mm taken to
/// be that.
double material_distance(const Material& a, const Material& b);

/// The material itself; or, of a textured object, at most 24 places' materials, spread so that each of 4096 places is
/// within a distance of 0.2 of one (or all 24 are in use).
std::vector<Material> representative_materials(const Object& object, const Material& material);

/// Index of the nearest.
std::size_t nearest_material(const std::vector<SampledMaterial>& all, const Material& here);

}  // namespace opaline
