// A binary tree over the lit cells of one object. Every node carries what the gather needs to use
// it in place of its cells: flux per irradiance channel, its centroid, first and second moments.
#pragma once

#include "render/irradiance/irradiance.h"

#include <cstdint>
#include <vector>

namespace opaline {

struct ClusterNode {
  glm::vec3 centroid;   ///< flux-weighted, mm
  float radius;         ///< of the sphere around the centroid that holds all its cells
  float covariance[6];  ///< flux-weighted second moments about the centroid: xx xy xz yy yz zz [mm^2]
  float area;           ///< sum of the lit cells' areas [mm^2]
  std::uint32_t skip;   ///< index of the next node when this one is used whole or left out
  std::uint32_t cell;   ///< a leaf's cell; no_cell for an inner node
  static constexpr std::uint32_t no_cell = ~0u;
  float trace() const { return covariance[0] + covariance[3] + covariance[5]; }
};

/// Nodes in depth-first order: the first child of node i is i + 1, its subtree ends at skip.
/// With several irradiance channels (etas, colours) the centroid and covariance are those of the
/// summed flux; each channel's own first moment about that centroid is kept beside it.
struct ClusterTree {
  int masses = 1;                   ///< channels of the irradiance field
  std::vector<ClusterNode> nodes;   ///< empty: nothing is lit
  std::vector<float> mass;          ///< node * masses + m: E A summed [mm^2 x irradiance]
  std::vector<float> first_moment;  ///< (node * 3 + axis) * masses + m; empty if masses == 1
  std::vector<double> total_mass;   ///< per channel
  std::size_t dark_cells = 0;       ///< cells without light, left out
};

ClusterTree build_cluster_tree(const SurfaceCells& cells, const IrradianceField& irradiance);

}  // namespace opaline
