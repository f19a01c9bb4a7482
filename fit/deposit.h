// The inner loop of the operator: a patch's flux goes to the radial nodes around its distance.
#pragma once

#include "fit/radial_basis.h"
#include "render/irradiance/patches.h"

namespace opaline {

/// accumulators[n * masses + m] += flux m of every patch times the basis function n at its distance
/// (two-point rule, see patches.h). weight may be null. Vectorised.
void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators);

}  // namespace opaline
