// The inner loop of the operator: a patch's flux goes to the radial nodes around its distance.
#pragma once

#include "fit/radial_basis.h"
#include "render/irradiance/patches.h"

#include <glm/vec4.hpp>

namespace opaline {

/// What a group of queries deposits (a list of patches for the gather). Parts of leaves' cells, most of the work, are
/// kept as what they are: all parts of a leaf have its flux but for a factor and its moments but for their scale.
class DepositList {
 public:
  /// Parts of one leaf: those from `first` up to the next run's first.
  struct Run {
    std::uint32_t leaf;
    std::size_t first;
  };

  explicit DepositList(int masses) : patches_(masses) {}

  void clear() { patches_.clear(), parts_.clear(), runs_.clear(); }
  void push(const ClusterTree& tree, std::size_t node, float moments) { patches_.push(tree, node, moments); }
  void push_part(const ClusterTree&, std::uint32_t leaf, const glm::vec3& centroid, float scale) {
    if (runs_.empty() || runs_.back().leaf != leaf) runs_.push_back({leaf, parts_.size()});
    parts_.emplace_back(centroid, scale);
  }
  /// Whole vectors can be read from the end of every run; after this it can only be cleared.
  void pad() {
    patches_.pad();
    runs_.push_back({0, parts_.size()});
    parts_.resize(parts_.size() + PatchList::lanes, glm::vec4(0));
  }

  const PatchList& patches() const { return patches_; }
  std::size_t run_count() const { return runs_.size() - 1; }
  const Run& run(std::size_t i) const { return runs_[i]; }
  /// Centroid and scale.
  const float* part(std::size_t i) const { return &parts_[i].x; }

 private:
  PatchList patches_;
  std::vector<glm::vec4> parts_;
  std::vector<Run> runs_;
};

/// accumulators[n * masses + m] += flux m of every patch times the basis function n at its distance
/// (two-point rule, see patches.h). weight may be null. Vectorised.
void deposit_patches(const RadialBasis& basis, const PatchList& patches, const float* weight, const glm::vec3& position,
                     float* accumulators);

/// The same for the parts of a list that has been padded.
void deposit_parts(const RadialBasis& basis, const ClusterTree& tree, const DepositList& list,
                   const glm::vec3& position, float* accumulators);

}  // namespace opaline
