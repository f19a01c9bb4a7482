// ProfileTable at many distances at once, on the vector target in force (simd.h).
#pragma once

#include "model/profile_table.h"

#include <cstddef>

namespace opaline {

/// out[t][i] = tables[t] at squared distance r2[i] >= 0 [mm^2], t < count <= 3, i < n. The lookups of
/// profile_table_kernel.h: from the rows or, with AVX-512 and tables of the same segments, from registers.
void evaluate_tables(const ProfileTable* const* tables, int count, const float* r2, std::size_t n, float* const* out);

/// sums[t] += sum of weight[i] * R_t(r2[i]): the bare table kernel, for measuring it. Float within 512 terms, double
/// from there on.
void sum_tables(const ProfileTable* const* tables, int count, const float* r2, const float* weight, std::size_t n,
                double* sums);

}  // namespace opaline
