// The hierarchical gather: for every query, a list of patches that stands for the whole surface.
//
// Queries are sorted along a Morton curve and walk the tree in groups: one traversal makes one list
// of accepted clusters for all of them. Cells too near for the group are judged again by each query
// and split into quarters until they are small enough, so the near field is integrated, not sampled.
//
// A Criterion says which error is allowed; a Sink consumes patches:
//   struct Criterion { static constexpr float moments;   // 1; 0: clusters are points (the published algorithm)
//                      void begin_group(const glm::vec3& centre, float radius);
//                      // May the node stand for its cells, for every query of the group?
//                      bool accept(const ClusterNode& node, float distance_to_centre) const;
//                      // May a cell or a part of it, seen by one query, stay whole?
//                      bool accept_part(float distance_to_centroid, float radius, float trace) const; };
//   struct Sink      { void begin(std::size_t query, const glm::vec3& position);
//                      void add(const PatchList& padded_patches, const float* weight);  // weight may be null
//                      void end(); };
#pragma once

#include "render/irradiance/patches.h"
#include "render/progress.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <span>

namespace opaline {

struct GatherCounts {
  std::uint64_t groups = 0, nodes_visited = 0, clusters = 0, near_cells = 0, cell_parts = 0;
  std::uint64_t depth_limit_reached = 0;
};

/// Indices of the points, ordered along a Morton curve through their bounding box.
std::vector<std::uint32_t> morton_order(std::span<const glm::vec3> points);

/// Works through groups of queries; one per thread.
template <typename Criterion, typename Sink>
class GroupGather {
 public:
  GroupGather(const ClusterTree& tree, const SurfaceCells& cells, Criterion criterion, Sink sink)
      : tree_(tree),
        cells_(cells),
        criterion_(std::move(criterion)),
        sink_(std::move(sink)),
        far_(tree.masses),
        near_(tree.masses),
        parts_(tree.masses) {}

  GatherCounts run(std::span<const glm::vec3> points, std::span<const std::uint32_t> group) {
    counts_ = {};
    ++counts_.groups;
    glm::vec3 centre(0);
    for (const std::uint32_t q : group) centre += points[q];
    centre /= static_cast<float>(group.size());
    float radius = 0;
    for (const std::uint32_t q : group) radius = std::max(radius, glm::length(points[q] - centre));
    criterion_.begin_group(centre, radius);
    traverse(centre);
    counts_.clusters = far_.size() * group.size();
    for (const std::uint32_t q : group) run_query(q, points[q]);
    return counts_;
  }

 private:
  static constexpr int max_depth = 20;

  void traverse(const glm::vec3& centre) {
    far_.clear();
    near_.clear();
    near_leaves_.clear();
    for (std::size_t i = 0; i < tree_.nodes.size();) {
      const ClusterNode& node = tree_.nodes[i];
      ++counts_.nodes_visited;
      const bool accepted = criterion_.accept(node, glm::length(node.centroid - centre));
      if (accepted) far_.push(tree_, i, Criterion::moments);
      if (!accepted && node.cell != ClusterNode::no_cell) {
        near_.push(tree_, i, Criterion::moments);
        near_leaves_.push_back(static_cast<std::uint32_t>(i));
      }
      i = accepted ? node.skip : i + 1;
    }
    far_.pad();
    near_.pad();
  }

  void run_query(std::uint32_t query, const glm::vec3& position) {
    sink_.begin(query, position);
    sink_.add(far_, nullptr);
    weight_.assign(PatchList::padded(near_.size()), 1.0f);
    parts_.clear();
    for (std::size_t i = 0; i < near_leaves_.size(); ++i) {
      const ClusterNode& node = tree_.nodes[near_leaves_[i]];
      if (acceptable(position, node.centroid, node.radius, node.trace())) continue;
      weight_[i] = 0;
      refine(position, near_leaves_[i], cells_[node.cell], node.radius, 1.0f, 0);
    }
    parts_.pad();
    sink_.add(near_, weight_.data());
    sink_.add(parts_, nullptr);
    sink_.end();
    counts_.near_cells += near_.size();
    counts_.cell_parts += parts_.size();
  }

  bool acceptable(const glm::vec3& position, const glm::vec3& centroid, float radius, float trace) const {
    return criterion_.accept_part(glm::length(centroid - position), radius, trace);
  }

  void refine(const glm::vec3& position, std::uint32_t leaf, const SurfaceCell& cell, float radius, float fraction,
              int depth) {
    SurfaceCell quarters[4];
    split_in_four(cell, quarters);
    const float quarter = fraction / 4, half_radius = radius / 2, trace = tree_.nodes[leaf].trace() * quarter;
    for (const SurfaceCell& part : quarters) {
      const glm::vec3 centroid = cell_centroid(part);
      const bool stop = depth + 1 == max_depth;
      if (stop || acceptable(position, centroid, half_radius, trace)) {
        counts_.depth_limit_reached += stop;
        parts_.push_part(tree_, leaf, centroid, quarter);
      } else {
        refine(position, leaf, part, half_radius, quarter, depth + 1);
      }
    }
  }

  const ClusterTree& tree_;
  const SurfaceCells& cells_;
  Criterion criterion_;
  Sink sink_;
  PatchList far_, near_, parts_;
  std::vector<std::uint32_t> near_leaves_;
  std::vector<float> weight_;
  GatherCounts counts_;
};

/// Gathers all points; make_criterion() and make_sink() are called once per task. The result does
/// not depend on the number of threads: groups are fixed by the points alone.
template <typename MakeCriterion, typename MakeSink>
GatherCounts gather(const ClusterTree& tree, const SurfaceCells& cells, std::span<const glm::vec3> points,
                    MakeCriterion&& make_criterion, MakeSink&& make_sink, std::size_t group_size = 64) {
  const std::vector<std::uint32_t> order = morton_order(points);
  const std::size_t groups = (order.size() + group_size - 1) / group_size;
  std::atomic<std::uint64_t> total[6]{};
  Progress progress(groups);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups, 4), [&](const auto& range) {
    GroupGather worker(tree, cells, make_criterion(), make_sink());
    for (std::size_t g = range.begin(); g != range.end(); ++g) {
      const std::size_t begin = g * group_size, end = std::min(begin + group_size, order.size());
      const GatherCounts c = worker.run(points, std::span(order).subspan(begin, end - begin));
      const std::uint64_t values[6] = {c.groups,     c.nodes_visited, c.clusters,
                                       c.near_cells, c.cell_parts,    c.depth_limit_reached};
      for (int i = 0; i < 6; ++i) total[i] += values[i];
    }
    progress.advance(range.size());
  });
  return {total[0], total[1], total[2], total[3], total[4], total[5]};
}

}  // namespace opaline
