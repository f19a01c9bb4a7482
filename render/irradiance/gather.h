// The hierarchical gather: for every query, lists of patches that stand for the whole surface.
//
// Queries are sorted along a Morton curve and walk the tree in groups of at most 512, 128, .. 1 neighbours: what may
// be used whole by all queries of a group goes on the group's list; the rest is opened, cells into quarters until they
// are small enough, so that the near field is integrated, not sampled. What is small against the group and would do for
// its middle is left to the group's parts.
//
// A Criterion says which error is allowed; a Sink consumes patches:
//   struct Criterion { static constexpr float moments;   // 1; 0: clusters are points (the published algorithm)
//                      void begin_group(const glm::vec3& centre, float radius);
//                      // May the node stand for its cells, for every query within group_radius of a point at
//                      // `distance` from its centroid?
//                      bool accept(const ClusterNode& node, float distance, float group_radius);
//                      // The same for a part of the leaf's cell, `scale` times as large.
//                      bool accept_part(const ClusterNode& leaf, float scale, float distance, float group_radius);
//                      // What was accepted last is used: with these fluxes, times `fraction`.
//                      void use(const float* mass, float fraction);
//                      // Bound of the error of what has been used since the last call, per output.
//                      std::array<float, 3> take_bound();
//                      // The group will be worked through again, with errors smaller by this factor.
//                      void tighten(float factor); };
//   struct Sink      { using Patches = PatchList;  // or what else has its clear(), push(), push_part() and pad()
//                      void begin_group(std::span<const std::uint32_t> queries, std::span<const glm::vec3> positions);
//                      // For `count` of the group's queries from `first` on.
//                      void add(const Patches& padded_patches, std::size_t first, std::size_t count,
//                               const std::array<float, 3>& bound);
//                      // Largest bound over what is allowed: above 1 the group is tried again, at most three times.
//                      float end_group(); };
#pragma once

#include "render/irradiance/morton.h"
#include "render/irradiance/patches.h"
#include "render/progress.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <numeric>
#include <span>

namespace opaline {

/// clusters, cells, cell_parts: patches used, each counted once per query.
/// nodes_visited: nodes and parts of cells that were judged.
struct GatherCounts {
  std::uint64_t groups = 0, nodes_visited = 0, clusters = 0, cells = 0, cell_parts = 0, depth_limit_reached = 0,
                groups_repeated = 0;

  GatherCounts& operator+=(const GatherCounts& c) {
    groups += c.groups, nodes_visited += c.nodes_visited, clusters += c.clusters, cells += c.cells;
    cell_parts += c.cell_parts, depth_limit_reached += c.depth_limit_reached, groups_repeated += c.groups_repeated;
    return *this;
  }
};

/// Works through groups of queries; one per thread.
template <typename Criterion, typename Sink>
class GroupGather {
 public:
  GroupGather(const ClusterTree& tree, const SurfaceCells& cells, Criterion criterion, Sink sink,
              std::size_t group_size)
      : tree_(tree), cells_(cells), criterion_(std::move(criterion)), sink_(std::move(sink)) {
    for (std::size_t size = group_size;; size = std::max<std::size_t>(1, size / 4)) {
      levels_.push_back({size, typename Sink::Patches(tree.masses), {}, {}, {}});
      if (size == 1) break;
    }
  }

  GatherCounts run(std::span<const glm::vec3> points, std::span<const MortonKey> group) {
    counts_ = {};
    ++counts_.groups;
    group_ = group;
    positions_.clear(), queries_.clear();
    for (const MortonKey& key : group) positions_.push_back(points[key.index]), queries_.push_back(key.index);
    const Sphere sphere = around(0, group.size());
    criterion_.begin_group(sphere.centre, sphere.radius);
    for (int attempt = 0; attempt < max_attempts; ++attempt) {
      sink_.begin_group(queries_, positions_);
      levels_[0].nodes.assign(1, 0);
      work(0, 0, group.size());
      const float excess = sink_.end_group();
      if (excess <= 1 || attempt + 1 == max_attempts) break;
      criterion_.tighten(std::max(0.7f / excess, 1e-4f));
      ++counts_.groups_repeated;
    }
    return counts_;
  }

 private:
  static constexpr int max_depth = 20, max_attempts = 4;

  /// Below this part of a group's radius a patch is left to the group's parts: opened, it would only make more work.
  static constexpr float small = 0.5f;
  /// A group wider than this part of the whole surface shares nothing.
  static constexpr float wide = 0.1f;

  /// A leaf's cell or a part of it, `scale` times as large; scale < 0: turned by half a turn.
  struct Part {
    std::uint32_t leaf;
    float scale;
    int depth;
    glm::vec3 centroid;
  };
  struct Level {
    std::size_t size;
    typename Sink::Patches patches;
    std::vector<std::uint32_t> nodes;  ///< roots of what has to be looked at
    std::vector<Part> parts;
    std::vector<std::size_t> pieces;  ///< sizes of the groups into which one of the level above falls
  };
  struct Sphere {
    glm::vec3 centre{0};
    float radius = 0;
  };

  Sphere around(std::size_t first, std::size_t count) const {
    Sphere s;
    for (std::size_t i = first; i < first + count; ++i) s.centre += positions_[i];
    s.centre /= static_cast<float>(count);
    for (std::size_t i = first; i < first + count; ++i)
      s.radius = std::max(s.radius, glm::length(positions_[i] - s.centre));
    return s;
  }

  void work(std::size_t l, std::size_t first, std::size_t count) {
    Level& level = levels_[l];
    const bool last = l + 1 == levels_.size();
    const Sphere sphere = last ? Sphere{positions_[first], 0} : around(first, count);
    level.patches.clear();
    if (!last) levels_[l + 1].nodes.clear(), levels_[l + 1].parts.clear();
    // Too wide a group for anything to be shared: straight to its parts.
    const bool skip = !last && sphere.radius > wide * tree_.nodes.front().extent.radius;
    if (skip) levels_[l + 1].nodes = level.nodes, levels_[l + 1].parts = level.parts;
    if (!skip) look(l, sphere, count);
    level.patches.pad();
    sink_.add(level.patches, first, count, criterion_.take_bound());
    if (!last) work_on_parts(l + 1, first, count);
  }

  void look(std::size_t l, const Sphere& sphere, std::size_t count) {
    for (const std::uint32_t root : levels_[l].nodes)
      for (std::size_t i = root; i < tree_.nodes[root].skip;) i = visit(l, i, sphere, count);
    for (const Part& part : levels_[l].parts) visit(l, part, sphere, count);
  }

  void work_on_parts(std::size_t l, std::size_t first, std::size_t count) {
    Level& level = levels_[l];
    if (level.nodes.empty() && level.parts.empty()) return;
    level.pieces.clear();
    morton_pieces(group_.subspan(first, count), level.size, level.pieces);
    for (const std::size_t piece : level.pieces) {
      work(l, first, piece);
      first += piece;
    }
  }

  /// Looks at a node and returns the next.
  std::size_t visit(std::size_t l, std::size_t i, const Sphere& sphere, std::size_t count) {
    const ClusterNode& node = tree_.nodes[i];
    const float distance = glm::length(node.centroid - sphere.centre);
    ++counts_.nodes_visited;
    if (criterion_.accept(node, distance, sphere.radius)) {
      levels_[l].patches.push(tree_, i, Criterion::moments);
      criterion_.use(&tree_.mass[i * static_cast<std::size_t>(tree_.masses)], 1);
      (node.leaf() ? counts_.cells : counts_.clusters) += count;
      return node.skip;
    }
    if (node.extent.radius < small * sphere.radius && criterion_.accept(node, distance, 0)) {
      levels_[l + 1].nodes.push_back(static_cast<std::uint32_t>(i));
      return node.skip;
    }
    if (node.leaf()) refine(l, {static_cast<std::uint32_t>(i), 1, 0, node.centroid}, sphere, count);
    return i + 1;
  }

  void visit(std::size_t l, const Part& part, const Sphere& sphere, std::size_t count) {
    const ClusterNode& leaf = tree_.nodes[part.leaf];
    const float distance = glm::length(part.centroid - sphere.centre), scale = std::abs(part.scale);
    const bool accepted = criterion_.accept_part(leaf, scale, distance, sphere.radius);
    ++counts_.nodes_visited;
    if (accepted || part.depth == max_depth) {
      counts_.depth_limit_reached += !accepted;
      counts_.cell_parts += count;
      levels_[l].patches.push_part(tree_, part.leaf, part.centroid, part.scale);
      criterion_.use(&tree_.mass[part.leaf * static_cast<std::size_t>(tree_.masses)], scale * scale);
    } else if (scale * leaf.extent.radius < small * sphere.radius && criterion_.accept_part(leaf, scale, distance, 0)) {
      levels_[l + 1].parts.push_back(part);
    } else {
      refine(l, part, sphere, count);
    }
  }

  /// Into the part's similar quarters: one at each corner, and the middle one, turned.
  void refine(std::size_t l, const Part& part, const Sphere& sphere, std::size_t count) {
    const float half = part.scale / 2;
    if (part.leaf != corners_of_) find_corners(part.leaf);
    for (int k = 0; k < 3; ++k)
      visit(l, {part.leaf, half, part.depth + 1, part.centroid + half * corners_[k]}, sphere, count);
    visit(l, {part.leaf, -half, part.depth + 1, part.centroid}, sphere, count);
  }

  void find_corners(std::uint32_t leaf) {
    const ClusterNode& node = tree_.nodes[leaf];
    const SurfaceCell& cell = cells_[node.cell];
    corners_[0] = cell.a - node.centroid, corners_[1] = cell.b - node.centroid, corners_[2] = cell.c - node.centroid;
    corners_of_ = leaf;
  }

  const ClusterTree& tree_;
  const SurfaceCells& cells_;
  Criterion criterion_;
  Sink sink_;
  std::vector<Level> levels_;
  std::span<const MortonKey> group_;
  std::vector<std::uint32_t> queries_;
  std::vector<glm::vec3> positions_;
  glm::vec3 corners_[3];  ///< of the cell of leaf corners_of_, from its centroid
  std::uint32_t corners_of_ = ~0u;
  GatherCounts counts_;
};

/// Gathers all points; make_criterion() and make_sink() are called once per task. The result does
/// not depend on the number of threads: groups are fixed by the points alone.
template <typename MakeCriterion, typename MakeSink>
GatherCounts gather(const ClusterTree& tree, const SurfaceCells& cells, std::span<const glm::vec3> points,
                    MakeCriterion&& make_criterion, MakeSink&& make_sink, std::size_t group_size = 512) {
  if (tree.nodes.empty()) return {};  // nothing is lit
  const std::vector<MortonKey> order = morton_sorted(points);
  std::vector<std::size_t> begins;
  morton_pieces(order, group_size, begins);
  std::exclusive_scan(begins.begin(), begins.end(), begins.begin(), std::size_t{0});
  const std::size_t groups = begins.size();
  begins.push_back(order.size());
  GatherCounts total;
  std::mutex mutex;
  Progress progress(groups);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, groups, 4), [&](const auto& range) {
    GroupGather worker(tree, cells, make_criterion(), make_sink(), group_size);
    GatherCounts counts;
    for (std::size_t g = range.begin(); g != range.end(); ++g)
      counts += worker.run(points, std::span(order).subspan(begins[g], begins[g + 1] - begins[g]));
    progress.advance(range.size());
    const std::lock_guard lock(mutex);
    total += counts;
  });
  return total;
}

}  // namespace opaline
