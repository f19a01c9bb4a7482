// The standard dipole at many distances at once, in floats on the vector target in force (simd.h): no table, the
// formula of standard_dipole.h itself.
//
// Error: 1e-6 relative to the formula in double at the same r^2, on every target, as long as sigma_tr d < 85 for both
// poles (d: distance from the pole) and R_d > 1e-36. A pole with sigma_tr d >= 86 counts as 0, and so may whatever is
// below 1e-36. Valid for z_r and z_v in [1e-9, 1e9] mm, sigma_tr z in [0, 1e9], r^2 in [0, 3e38] mm^2: results are
// finite and >= 0.
#pragma once

#include "model/profiles/standard_dipole.h"

#include <cstddef>

namespace opaline {

/// out[c][i] = R_d of dipoles[c] [1/mm^2] at r2[i] [mm^2], c < 3, i < n.
void evaluate_dipoles_rgb(const StandardDipole<double> (&dipoles)[3], const float* r2, std::size_t n,
                          float* const (&out)[3]);

}  // namespace opaline
