// The inner loop of every renderer here: flux times profile, summed over patches.
#pragma once

#include "model/profile_table.h"
#include "render/irradiance/patches.h"

#include <array>
#include <span>

namespace opaline {

/// Up to three distinct profiles (equal channels share one) against one or three flux channels.
///   masses == 1: sums[t] belongs to table t, t < table_count
///   masses == 3: sums[c] is flux channel c with table table_of[c]
struct ProfileSum {
  const ProfileTable* tables[3] = {};
  int table_count = 1;
  int table_of[3] = {0, 0, 0};
};

/// sums[q][] += sum over patches of weight * flux * R(|positions[q] - patch|) by the two-point rule, for every query.
/// Vectorised over patches; weight may be null. Queries share blocks of patches while these are in the cache, so
/// give many queries at once against long lists. Float within blocks of 512 patches, double between them: the
/// relative error of the addition stays below 1e-6 for any number of terms.
void add_profile_sums(const ProfileSum& profile, const PatchList& patches, const float* weight,
                      std::span<const glm::vec3> positions, std::array<float, 3>* sums);

/// The same without weights, query q leaving out the patches skipped[q], which ascend.
void add_profile_sums(const ProfileSum& profile, const PatchList& patches, std::span<const glm::vec3> positions,
                      const std::vector<std::uint32_t>* skipped, std::array<float, 3>* sums);

/// The same for one query.
inline void add_profile_sum(const ProfileSum& profile, const PatchList& patches, const float* weight,
                            const glm::vec3& position, float* sums) {
  std::array<float, 3> sum{};
  add_profile_sums(profile, patches, weight, {&position, 1}, &sum);
  const int count = patches.masses() == 3 ? 3 : profile.table_count;
  for (int i = 0; i < count; ++i) sums[i] += sum[static_cast<std::size_t>(i)];
}

}  // namespace opaline
