// Patches: what a query sums over. A patch is a cluster, a cell or a part of a cell, reduced to
// its flux and its moments up to the second.
//
// Two-point rule. For a query at D from the patch's centroid, q = |D - delta|^2 over the patch has
//   mean q0 = |D|^2 + tr C
//   variance V = 4 D^T C D - 4 E (D . delta) |delta|^2 + var |delta|^2
//   third central moment S ~ -8 E (D . delta)^3 + 4 tr C D^T C D   (the second term exact for a disk)
// Two values of q with two weights reproduce all three (Gauss's quadrature for the flux over q), so any profile f(q)
// is integrated with an error of the fourth order. As S is not exact the points of a patch that looks large may come to
// lie outside of it, where the profile may be anything: they are kept within (|D| - radius)^2 .. (|D| + radius)^2. A
// channel whose own centroid differs shifts flux between the two
// points by its first moment.
#pragma once

#include "render/irradiance/cluster_tree.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace opaline {

/// Blocks of `lanes` patches, each a structure of arrays, for the geometry (one stream to read, whose lines don't fight
/// for the same sets of the cache); `masses` floats in a row for the fluxes.
class PatchList {
 public:
  explicit PatchList(int masses = 1) : masses_(static_cast<std::size_t>(masses)) {}

  void clear() { count_ = 0; }
  std::size_t size() const { return count_; }
  int masses() const { return static_cast<int>(masses_); }

  /// Appends a node of the tree; moments = 0 reduces it to a point at its centroid.
  void push(const ClusterTree& tree, std::size_t node, float moments = 1) {
    const std::size_t i = grow();
    const ClusterNode& n = tree.nodes[node];
    set_geometry(i, n.centroid, n, moments);
    nodes_[i] = static_cast<std::uint32_t>(node);
    for (std::size_t m = 0; m < masses_; ++m) mass_[i * masses_ + m] = tree.mass[node * masses_ + m];
    if (masses_ == 1) return;
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t m = 0; m < masses_; ++m)
        first_[axis][i * masses_ + m] = moments * tree.first_moment[(node * 3 + axis) * masses_ + m];
  }
  /// Appends a similar part of a leaf's cell: its centroid, and its size as a fraction of the cell's; below 0 if it is
  /// turned by half a turn.
  void push_part(const ClusterTree& tree, std::size_t leaf, const glm::vec3& centroid, float scale) {
    const std::size_t i = grow();
    const float fraction = scale * scale;
    set_geometry(i, centroid, tree.nodes[leaf], scale);
    nodes_[i] = static_cast<std::uint32_t>(leaf);
    for (std::size_t m = 0; m < masses_; ++m) mass_[i * masses_ + m] = fraction * tree.mass[leaf * masses_ + m];
    if (masses_ == 1) return;
    for (auto& axis : first_) std::fill_n(axis.begin() + static_cast<std::ptrdiff_t>(i * masses_), masses_, 0.0f);
  }

  /// Appends a point with the same flux in every channel.
  void push_point(const glm::vec3& position, float mass) {
    const std::size_t i = grow();
    set_geometry(i, position, ClusterNode{}, 0);
    nodes_[i] = 0;
    std::fill_n(mass_.begin() + static_cast<std::ptrdiff_t>(i * masses_), masses_, mass);
    if (masses_ == 1) return;
    for (auto& axis : first_) std::fill_n(axis.begin() + static_cast<std::ptrdiff_t>(i * masses_), masses_, 0.0f);
  }

  /// Geometry rows: 0-2 centroid, 3-8 covariance xx xy xz yy yz zz, 9 trace, 10 variance of |delta|^2,
  /// 11-20 coefficients of E (x . delta)^3, 21 radius.
  /// The field of patch i and of those behind it up to the next multiple of `lanes`.
  const float* geometry(int field, std::size_t i) const { return &geometry_[place(field, i)]; }
  const float* mass() const { return mass_.data(); }
  /// The tree's node each patch is, or is a part of.
  const std::uint32_t* nodes() const { return nodes_.data(); }
  const float* first_moment(int axis) const { return first_[axis].data(); }
  static constexpr int rows = 22;

  /// Kernels read whole vectors: the list is followed by patches without flux up to a multiple of
  /// this many.
  static constexpr std::size_t lanes = 16;
  static std::size_t padded(std::size_t count) { return (count + lanes - 1) / lanes * lanes; }
  void pad() {
    const std::size_t end = padded(count_), saved = count_;
    while (count_ < end) {
      const std::size_t i = grow();
      for (int field = 0; field < rows; ++field) geometry_[place(field, i)] = 0;
      nodes_[i] = 0;
      std::fill_n(mass_.begin() + static_cast<std::ptrdiff_t>(i * masses_), masses_, 0.0f);
      if (masses_ > 1)
        for (auto& axis : first_) std::fill_n(axis.begin() + static_cast<std::ptrdiff_t>(i * masses_), masses_, 0.0f);
    }
    count_ = saved;
  }

 private:
  std::size_t grow() {
    if (count_ == nodes_.size()) {
      const std::size_t capacity = count_ ? 2 * count_ : 256;
      geometry_.resize(capacity * rows);
      mass_.resize(capacity * masses_);
      nodes_.resize(capacity);
      if (masses_ > 1)
        for (auto& axis : first_) axis.resize(capacity * masses_);
    }
    return count_++;
  }
  void set_geometry(std::size_t i, const glm::vec3& centroid, const ClusterNode& n, float scale) {
    const float s2 = scale * scale, s3 = s2 * scale;
    float* const g = &geometry_[place(0, i)];
    for (int axis = 0; axis < 3; ++axis) g[static_cast<std::size_t>(axis) * lanes] = centroid[axis];
    for (std::size_t k = 0; k < 6; ++k) g[(3 + k) * lanes] = s2 * n.covariance[k];
    g[9 * lanes] = s2 * n.extent.trace;
    g[10 * lanes] = s2 * s2 * n.extent.deviation * n.extent.deviation;
    for (std::size_t k = 0; k < n.third.size(); ++k) g[(11 + k) * lanes] = s3 * n.third[k];
    g[21 * lanes] = std::abs(scale) * n.extent.radius;
  }
  static std::size_t place(int field, std::size_t i) {
    return (i / lanes * rows + static_cast<std::size_t>(field)) * lanes + i % lanes;
  }

  std::size_t masses_, count_ = 0;
  std::vector<float> geometry_, mass_, first_[3];
  std::vector<std::uint32_t> nodes_;
};

}  // namespace opaline
