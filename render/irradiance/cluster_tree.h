// A binary tree over the lit cells of one object. Every node carries what the gather needs to use it in place of
// its cells (flux per irradiance channel, centroid, moments up to the third) and what bounds the error of doing so.
#pragma once

#include "render/irradiance/irradiance.h"
#include "render/irradiance/moments.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace opaline {

/// What the error of a node used whole depends on. delta: place relative to the centroid, weighted by flux.
struct ClusterExtent {
  float radius;     ///< of a sphere around the centroid that holds all its cells [mm]
  float trace;      ///< E |delta|^2 [mm^2]
  float deviation;  ///< of |delta|^2: the root of its variance [mm^2]
  float stretch;    ///< >= the largest E (u . delta)^2 over unit u [mm^2]
  float fourth;     ///< >= the largest E (u . delta)^4 over unit u, to the power 1/4 [mm]
  float bulge;      ///< >= E (|delta|^2 - trace)^4, to the power 1/4 [mm^2]
  float mixed;      ///< norm of E delta delta^T (|delta|^2 - trace) - trace/3 E delta delta^T: 0 for a disk [mm^4]
  float unlike;     ///< largest relative difference of a channel's flux density from the sum's, over the cells

  /// As large as the larger of both in every way that raises the error: a trace of 0 is the worst.
  ClusterExtent with(const ClusterExtent& o) const {
    return {std::max(radius, o.radius),       0,
            std::max(deviation, o.deviation), std::max(stretch, o.stretch),
            std::max(fourth, o.fourth),       std::max(bulge, o.bulge),
            std::max(mixed, o.mixed),         std::max(unlike, o.unlike)};
  }
  /// Of a similar part, `scale` times as large.
  ClusterExtent scaled(float scale) const {
    const float s2 = scale * scale, s4 = s2 * s2;
    return {scale * radius, s2 * trace, s2 * deviation, s2 * stretch, scale * fourth, s2 * bulge, s4 * mixed, unlike};
  }
};

struct alignas(64) ClusterNode {
  glm::vec3 centroid;  ///< flux-weighted, mm
  std::uint32_t skip;  ///< index of the next node when this one is used whole or left out
  std::uint32_t cell;  ///< a leaf's cell; no_cell for an inner node
  float area;          ///< sum of the lit cells' areas [mm^2]
  ClusterExtent extent;
  // The first cache line ends here: a traversal reads no further.
  float covariance[6];  ///< second moments about the centroid: xx xy xz yy yz zz [mm^2]
  Form<3> third;        ///< E (x . delta)^3, see moments.h [mm^3]
  float unused[2];      // no hidden padding: equal nodes have equal bytes

  static constexpr std::uint32_t no_cell = ~0u;
  bool leaf() const { return cell != no_cell; }
};

/// Nodes in depth-first order: the first child of node i is i + 1, its subtree ends at skip.
/// With several irradiance channels (etas, colours) the centroid and the moments are those of the
/// summed flux; each channel's own first moment about that centroid is kept beside it.
struct ClusterTree {
  int masses = 1;                   ///< channels of the irradiance field
  std::vector<ClusterNode> nodes;   ///< empty: nothing is lit
  std::vector<float> mass;          ///< node * masses + m: E A summed [mm^2 x irradiance]
  std::vector<float> first_moment;  ///< (node * 3 + axis) * masses + m; empty if masses == 1
  std::vector<double> total_mass;   ///< per channel
  std::size_t dark_cells = 0;       ///< cells without light, left out

  std::size_t bytes() const {
    return nodes.size() * sizeof(ClusterNode) + (mass.size() + first_moment.size()) * sizeof(float);
  }
};

/// Splits at the planes of an octree (the bits of the Morton code), down to single cells.
ClusterTree build_cluster_tree(const SurfaceCells& cells, const IrradianceField& irradiance);

}  // namespace opaline
