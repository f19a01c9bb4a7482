// The inner loop of every renderer here: flux times profile, summed over patches.
#pragma once

#include "model/profile_table.h"
#include "render/irradiance/patches.h"

namespace opaline {

/// Up to three distinct profiles (equal channels share one) against one or three flux channels.
///   masses == 1: sums[t] belongs to table t, t < table_count
///   masses == 3: sums[c] is flux channel c with table table_of[c]
struct ProfileSum {
  const ProfileTable* tables[3] = {};
  int table_count = 1;
  int table_of[3] = {0, 0, 0};
};

/// sums[] += sum over patches of weight * flux * R(|position - patch|) by the two-point rule.
/// Vectorised over patches; weight may be null. Float within blocks of 1024 patches, double between
/// them: the relative error of the addition stays below 1e-6 for any number of terms.
void add_profile_sum(const ProfileSum& profile, const PatchList& patches, const float* weight,
                     const glm::vec3& position, float* sums);

}  // namespace opaline
