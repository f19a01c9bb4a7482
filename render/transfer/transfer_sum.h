// The inner loop of the precomputation: what many lights bring to a vertex, by the patches of a gather.
#pragma once

#include "render/irradiance/profile_sum.h"
#include "render/transfer/transfer_tree.h"

#include <array>
#include <span>

namespace opaline {

/// For a vertex that has an element of its own: the leaf, and the mean of each table's profile over its disc.
struct OwnDisc {
  std::uint32_t node;
  std::array<float, 3> mean;
};

/// sums[(q * tables + t) * transfer_columns + k] += sum over patches of flux k times R_t(|positions[q] - patch|), by
/// the two-point rule, in which every column moves flux by its own first moment. The profile is looked up once for
/// all columns. own: for every query, or empty.
void add_transfer_sums(const ProfileSum& profile, const TransferTree& tree, const PatchList& patches,
                       std::span<const glm::vec3> positions, std::span<const OwnDisc> own, float* sums);

}  // namespace opaline
