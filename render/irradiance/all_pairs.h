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
//                      bool accept(const ClusterExtent& extent, float distance, float group_radius); };
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
  float falling_from;               ///< [mm]
  PatchList whole;                  ///< all cells, in the tree's order
  std::vector<std::uint32_t> rank;  ///< per node: cells before it
  ClusterExtent largest{};          ///< no cell is larger in any way

  AllPairs(const ClusterTree& t, const SurfaceCells& c, const ProfileSum& p, float from)
      : tree(t), cells(c), profile(p), falling_from(from), whole(t.masses) {
    rank.reserve(tree.nodes.size());
    for (std::size_t i = 0; i < tree.nodes.size(); ++i) {
      rank.push_back(static_cast<std::uint32_t>(whole.size()));
      const ClusterNode& node = tree.nodes[i];
      if (!node.leaf()) continue;
      whole.push(tree, i);
      largest = largest.with(node.extent);
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
      if (node.leaf() && !criterion_.accept(node.extent, distance, 0)) {
        near.push_back(shared_.rank[i]);
        split(position, i, shared_.cells[node.cell], 1, 0);
      }
      i = !node.leaf() && all_whole(distance - node.extent.radius) ? node.skip : i + 1;
    }
    parts_.pad();
    counts_.cells += shared_.whole.size() - near.size();
    counts_.cell_parts += parts_.size();
  }

  /// Whether every cell further away than this may stay whole.
  bool all_whole(float distance) {
    return distance > shared_.falling_from && criterion_.accept(shared_.largest, distance, 0);
  }

  /// `scale`: of the cell or part against the leaf's cell; below 0 it is turned by half a turn.
  void split(const glm::vec3& position, std::size_t leaf, const SurfaceCell& cell, float scale, int depth) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    const ClusterExtent extent = shared_.tree.nodes[leaf].extent.scaled(std::abs(scale) / 2);
    for (int k = 0; k < 4; ++k) {
      const float part_scale = k == 3 ? -scale / 2 : scale / 2;  // the middle quarter is turned
      const glm::vec3 centroid = cell_centroid(quarters[k]);
      const bool whole = criterion_.accept(extent, glm::length(centroid - position), 0);
      if (whole || depth + 1 == max_depth) {
        counts_.depth_limit_reached += !whole;
        parts_.push_part(shared_.tree, leaf, centroid, part_scale);
      } else {
        split(position, leaf, quarters[k], part_scale, depth + 1);
      }
    }
  }

  const AllPairs& shared_;
  Criterion criterion_;
  PatchList parts_;
  std::array<std::vector<std::uint32_t>, AllPairs::group_size> near_;
  GatherCounts counts_;
};

/// sums[q][t] += B by table t (or flux channel, profile_sum.h) at points[q]. Counts: `cells` are summed whole,
/// `cell_parts` replace the others, `nodes_visited` is the price of finding them. The result does not depend on the
/// number of threads.
template <typename Criterion>
GatherCounts sum_all_pairs(const ClusterTree& tree, const SurfaceCells& cells, const ProfileSum& profile,
                           std::span<const glm::vec3> points, const Criterion& criterion, float falling_from,
                           std::vector<std::array<float, 3>>& sums) {
  const AllPairs shared(tree, cells, profile, falling_from);
  std::vector<std::uint32_t> order;
  for (const MortonKey& key : morton_sorted(points)) order.push_back(key.index);
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
    total += c;
  });
  return total;
}

}  // namespace opaline
