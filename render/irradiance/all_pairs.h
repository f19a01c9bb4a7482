// The sum over every cell for every point: what brute_force is.
//
// A cell stands whole, as one patch by the two-point rule (patches.h), unless it is so near to the point that the
// criterion asks for its quarters, or theirs, down to 20 levels. The list of whole cells is made once; points go
// through it in groups of 64, block by block, so that it is read from the first cache, and each leaves out its near
// cells. One pair (a cell and a point) is two evaluations of the profile in every channel.
//
//   struct Criterion { void begin_group(const glm::vec3& position, float radius);  // radius is 0: one point at a time
//                      // May a cell or a part of it stay whole? The smaller the more so; the further too, but only
//                      // beyond `falling_from`: within its core a profile is flat, and steepest a little further out.
//                      bool accept_part(float distance, float radius, float trace) const; };
#pragma once

#include "render/irradiance/gather.h"
#include "render/irradiance/profile_sum.h"

#include <array>
#include <mutex>

namespace opaline {

/// What all groups of points share.
struct AllPairs {
  static constexpr std::size_t group_size = 64;
  const ClusterTree& tree;
  const SurfaceCells& cells;
  const ProfileSum& profile;
  float falling_from;                           ///< [mm]
  PatchList whole;                              ///< all cells, in the tree's order
  std::vector<std::uint32_t> rank;              ///< per node: cells before it
  float largest_radius = 0, largest_trace = 0;  ///< of a cell

  AllPairs(const ClusterTree& t, const SurfaceCells& c, const ProfileSum& p, float from)
      : tree(t), cells(c), profile(p), falling_from(from), whole(t.masses) {
    rank.reserve(tree.nodes.size());
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      rank.push_back(static_cast<std::uint32_t>(whole.size()));
      const ClusterNode& node = tree.nodes[i];
      if (node.cell == ClusterNode::no_cell) continue;
      whole.push(tree, i);
      largest_radius = std::max(largest_radius, node.radius);
      largest_trace = std::max(largest_trace, node.trace());
    }
    whole.pad();
  }
};

/// Works through groups of points; one per task.
template <typename Criterion>
class PairWorker {
 public:
  PairWorker(const AllPairs& shared, Criterion criterion)
      : shared_(shared), criterion_(std::move(criterion)), parts_(shared.tree.masses) {}

  /// sums[q] += the sum at points[q], for every q of the group.
  void run(std::span<const glm::vec3> points, std::span<const std::uint32_t> group,
           std::vector<std::array<float, 3>>& sums) {
    std::array<std::array<float, 3>, AllPairs::group_size> sum{};
    std::array<glm::vec3, AllPairs::group_size> positions;
    for (std::size_t q = 0; q < group.size(); ++q) {
      positions[q] = points[group[q]];
      split_near_cells(positions[q], near_[q]);
      add_profile_sum(shared_.profile, parts_, nullptr, positions[q], sum[q].data());
    }
    const auto used = std::span(positions).first(group.size());
    add_profile_sums(shared_.profile, shared_.whole, used, near_.data(), sum.data());
    for (std::size_t q = 0; q < group.size(); ++q)
      for (std::size_t t = 0; t < 3; ++t) sums[group[q]][t] += sum[q][t];
    ++counts_.groups;
  }

  const GatherCounts& counts() const { return counts_; }

 private:
  static constexpr int max_depth = 20;

  /// Fills parts_, and lists the cells they replace.
  void split_near_cells(const glm::vec3& position, std::vector<std::uint32_t>& near) {
    criterion_.begin_group(position, 0);
    parts_.clear();
    near.clear();
    const std::vector<ClusterNode>& nodes = shared_.tree.nodes;
    for (std::size_t i = 0; i < nodes.size();) {
      ++counts_.nodes_visited;
      const ClusterNode& node = nodes[i];
      const float distance = glm::length(node.centroid - position);
      const bool leaf = node.cell != ClusterNode::no_cell;
      if (leaf && !criterion_.accept_part(distance, node.radius, node.trace())) {
        near.push_back(shared_.rank[i]);
        split(position, i, shared_.cells[node.cell], node.radius, 1.0f, 0);
      }
      i = !leaf && all_whole(distance - node.radius) ? node.skip : i + 1;
    }
    parts_.pad();
    counts_.near_cells += near.size();
    counts_.cell_parts += parts_.size();
    counts_.clusters += shared_.whole.size() - near.size();
  }

  /// Whether every cell further away than this may stay whole.
  bool all_whole(float distance) const {
    return distance > shared_.falling_from &&
           criterion_.accept_part(distance, shared_.largest_radius, shared_.largest_trace);
  }

  void split(const glm::vec3& position, std::size_t leaf, const SurfaceCell& cell, float radius, float fraction,
             int depth) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    const float quarter = fraction / 4, trace = shared_.tree.nodes[leaf].trace() * quarter;
    for (const SurfaceCell& part : quarters) {
      const glm::vec3 centroid = cell_centroid(part);
      const bool whole = criterion_.accept_part(glm::length(centroid - position), radius / 2, trace);
      if (whole || depth + 1 == max_depth) {
        counts_.depth_limit_reached += !whole;
        parts_.push_part(shared_.tree, leaf, centroid, quarter);
      } else {
        split(position, leaf, part, radius / 2, quarter, depth + 1);
      }
    }
  }

  const AllPairs& shared_;
  Criterion criterion_;
  PatchList parts_;
  std::array<std::vector<std::uint32_t>, AllPairs::group_size> near_;
  GatherCounts counts_;
};

/// sums[q][t] += B by table t (or flux channel, profile_sum.h) at points[q]. Counts: `clusters` are the cells summed
/// whole, `near_cells` those replaced by `cell_parts`, `nodes_visited` the price of finding them. The result does not
/// depend on the number of threads.
template <typename Criterion>
GatherCounts sum_all_pairs(const ClusterTree& tree, const SurfaceCells& cells, const ProfileSum& profile,
                           std::span<const glm::vec3> points, const Criterion& criterion, float falling_from,
                           std::vector<std::array<float, 3>>& sums) {
  const AllPairs shared(tree, cells, profile, falling_from);
  const std::vector<std::uint32_t> order = morton_order(points);
  const std::size_t groups = (order.size() + AllPairs::group_size - 1) / AllPairs::group_size;
  GatherCounts total;
  std::mutex mutex;
  Progress progress(groups);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups), [&](const auto& range) {
    PairWorker<Criterion> worker(shared, criterion);
    for (std::size_t g = range.begin(); g != range.end(); ++g) {
      const std::size_t begin = g * AllPairs::group_size, end = std::min(begin + AllPairs::group_size, order.size());
      worker.run(points, std::span(order).subspan(begin, end - begin), sums);
    }
    progress.advance(range.size());
    const GatherCounts& c = worker.counts();
    const std::lock_guard lock(mutex);
    total = {total.groups + c.groups,         total.nodes_visited + c.nodes_visited,
             total.clusters + c.clusters,     total.near_cells + c.near_cells,
             total.cell_parts + c.cell_parts, total.depth_limit_reached + c.depth_limit_reached};
  });
  return total;
}

}  // namespace opaline
