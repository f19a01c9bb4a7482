// A cluster tree over the elements of a surface whose nodes carry the flux of many lights at once: one walk through it
// serves them all.
//
// The tree is made of areas alone, as if everything were lit evenly. Every column (a light) has its own flux in each
// node and its own first moment about the node's centroid, so a cluster is wrong for a column only in the second
// order of how its light varies over the cluster.
#pragma once

#include "render/irradiance/cluster_tree.h"
#include "render/transfer/transfer_elements.h"

#include <vector>

namespace opaline {

class TransferTree {
 public:
  /// The cells must outlive it.
  explicit TransferTree(const SurfaceCells& cells);

  /// Takes the columns' irradiance, [cell * transfer_columns + column], up to all nodes.
  void fill(const std::vector<float>& irradiance);

  const ClusterTree& tree() const { return tree_; }
  const SurfaceCells& cells() const { return cells_; }
  /// transfer_columns fluxes of a node.
  const float* mass(std::size_t node) const { return &mass_[node * transfer_columns]; }
  /// First moments x, y, z of a node, transfer_columns each; null for a leaf, whose light is even.
  const float* moments(std::size_t node) const {
    return inner_[node] == leaf ? nullptr : &moments_[inner_[node] * 3 * transfer_columns];
  }
  std::size_t bytes() const { return (mass_.size() + moments_.size()) * sizeof(float) + tree_.bytes(); }

 private:
  static constexpr std::uint32_t leaf = ~0u;
  void fill_node(std::size_t node, const std::vector<float>& irradiance);
  void add_child(std::size_t node, std::size_t child);

  const SurfaceCells& cells_;
  ClusterTree tree_;
  std::vector<std::uint32_t> inner_;  ///< number among the inner nodes
  std::vector<float> mass_, moments_;
};

}  // namespace opaline
