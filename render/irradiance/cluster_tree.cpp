#include "render/irradiance/cluster_tree.h"

#include "render/irradiance/morton.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace opaline {
namespace {

/// Everything of a node's extent that follows from its moments.
ClusterExtent extent_of(const Moments& moments, float radius) {
  const float trace = moments.trace();
  const Form<2> radial = laplacian<4>(moments.fourth);  // 12 E (x . delta)^2 |delta|^2
  Form<2> mixed;
  for (std::size_t k = 0; k < mixed.size(); ++k) mixed[k] = radial[k] / 12 - 4.0f / 3 * trace * moments.second[k];
  const float variance = std::max(laplacian<2>(radial)[0] / 24 - trace * trace, 0.0f);
  const float off = std::max(radius * radius - trace, trace);  // | |delta|^2 - trace | is no larger
  return {radius,
          trace,
          std::sqrt(variance),
          frobenius_norm<2>(moments.second),
          std::sqrt(std::sqrt(frobenius_norm<4>(moments.fourth))),
          std::sqrt(off * std::sqrt(variance)),
          frobenius_norm<2>(mixed),
          0};
}

/// What a parent needs of a subtree besides its node.
struct Subtree {
  Moments moments;
  glm::vec3 lo, hi;  ///< box around its cells
};

/// From the centre to the farthest corner of a box.
float farthest_corner(const glm::vec3& centre, const Subtree& s) {
  return glm::length(glm::max(centre - s.lo, s.hi - centre));
}

struct Builder {
  const SurfaceCells& cells;
  const IrradianceField& field;
  ClusterTree& tree;
  std::vector<MortonKey> order{};          // lit cells in leaf order
  std::vector<float> lowest{}, highest{};  // per node and channel: its share of the flux density, over the cells
  static constexpr std::size_t parallel_size = 2048, exact_radius_size = 32;

  std::size_t masses() const { return static_cast<std::size_t>(tree.masses); }

  Subtree make_leaf(std::size_t index, std::uint32_t cell_index) {
    const SurfaceCell& cell = cells[cell_index];
    ClusterNode& node = tree.nodes[index];
    node.centroid = cell_centroid(cell);
    node.area = cell_area(cell);
    node.cell = cell_index;
    const float* e = &field.values[cell_index * masses()];
    float sum = 0, square = 0;
    for (std::size_t m = 0; m < masses(); ++m) sum += e[m];
    for (std::size_t m = 0; m < masses(); ++m) {
      tree.mass[index * masses() + m] = e[m] * node.area;
      if (masses() > 1) lowest[index * masses() + m] = highest[index * masses() + m] = e[m] / sum;
    }
    const std::array<glm::vec3, 3> corners = {cell.a - node.centroid, cell.b - node.centroid, cell.c - node.centroid};
    for (const glm::vec3& d : corners) square = std::max(square, glm::dot(d, d));
    const Moments moments = triangle_moments(corners);
    finish(node, moments, std::sqrt(square));
    return {moments, glm::min(glm::min(cell.a, cell.b), cell.c), glm::max(glm::max(cell.a, cell.b), cell.c)};
  }

  static void finish(ClusterNode& node, const Moments& moments, float radius) {
    node.extent = extent_of(moments, radius);
    for (std::size_t k = 0; k < 6; ++k)
      node.covariance[k] = (k == 0 || k == 3 || k == 5 ? 1.0f : 0.5f) * moments.second[k];
    node.third = moments.third;
  }

  float weight_of(std::size_t node) const {
    float sum = 0;
    for (std::size_t m = 0; m < masses(); ++m) sum += tree.mass[node * masses() + m];
    return sum;
  }

  Subtree merge(std::size_t index, std::size_t left, std::size_t right, const Subtree& a, const Subtree& b,
                float radius) {
    ClusterNode& node = tree.nodes[index];
    const ClusterNode &l = tree.nodes[left], &r = tree.nodes[right];
    const float p = weight_of(left) / (weight_of(left) + weight_of(right)), q = 1 - p;
    node.cell = ClusterNode::no_cell;
    node.area = l.area + r.area;
    const Subtree sum{merged(a.moments, p, b.moments, q, r.centroid - l.centroid), glm::min(a.lo, b.lo),
                      glm::max(a.hi, b.hi)};
    const float of_children = std::max(glm::length(l.centroid - node.centroid) + l.extent.radius,
                                       glm::length(r.centroid - node.centroid) + r.extent.radius);
    finish(node, sum.moments, radius > 0 ? radius : std::min(of_children, farthest_corner(node.centroid, sum)));
    merge_channels(index, left, right);
    return sum;
  }

  void merge_channels(std::size_t index, std::size_t left, std::size_t right) {
    const std::size_t n = masses();
    for (const std::size_t child : {left, right}) {
      const glm::vec3 d = tree.nodes[child].centroid - tree.nodes[index].centroid;
      for (std::size_t m = 0; m < n; ++m) {
        const float mass = tree.mass[child * n + m];
        tree.mass[index * n + m] += mass;
        if (n == 1) continue;
        for (std::size_t axis = 0; axis < 3; ++axis)
          tree.first_moment[(index * 3 + axis) * n + m] +=
              tree.first_moment[(child * 3 + axis) * n + m] + mass * d[static_cast<int>(axis)];
      }
    }
    if (n > 1) compare_channels(index, left, right);
  }

  /// How unlike the sum a channel is: its density relative to the sum's, against the same of the whole node.
  void compare_channels(std::size_t index, std::size_t left, std::size_t right) {
    const std::size_t n = masses();
    const float whole = weight_of(index);
    for (std::size_t m = 0; m < n; ++m) {
      const float lo = lowest[index * n + m] = std::min(lowest[left * n + m], lowest[right * n + m]);
      const float hi = highest[index * n + m] = std::max(highest[left * n + m], highest[right * n + m]);
      const float mass = tree.mass[index * n + m];
      if (mass <= 0) continue;
      float& unlike = tree.nodes[index].extent.unlike;
      unlike = std::max({unlike, hi * whole / mass - 1, 1 - lo * whole / mass});
    }
  }

  /// Of the sphere around `centre` that holds the cells; 0 if there are too many to look at each.
  float exact_radius(const glm::vec3& centre, std::size_t begin, std::size_t end) const {
    if (end - begin > exact_radius_size) return 0;
    float square = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const SurfaceCell& cell = cells[order[i].index];
      for (const glm::vec3& vertex : {cell.a, cell.b, cell.c})
        square = std::max(square, glm::dot(vertex - centre, vertex - centre));
    }
    return std::sqrt(square);
  }

  Subtree build(std::size_t index, std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    tree.nodes[index].skip = static_cast<std::uint32_t>(index + 2 * count - 1);
    if (count == 1) return make_leaf(index, order[begin].index);
    const std::size_t middle = begin + morton_split(std::span(order).subspan(begin, count)), left = index + 1,
                      right = left + 2 * (middle - begin) - 1;
    Subtree a, b;
    const auto build_left = [&] { a = build(left, begin, middle); };
    const auto build_right = [&] { b = build(right, middle, end); };
    if (count > parallel_size) {
      tbb::parallel_invoke(build_left, build_right);
    } else {
      build_left(), build_right();
    }
    const float p = weight_of(left) / (weight_of(left) + weight_of(right));
    ClusterNode& node = tree.nodes[index];
    node.centroid = tree.nodes[left].centroid + (1 - p) * (tree.nodes[right].centroid - tree.nodes[left].centroid);
    return merge(index, left, right, a, b, exact_radius(node.centroid, begin, end));
  }
};

/// Indices of the cells with light.
std::vector<std::uint32_t> lit_cells(const IrradianceField& field, std::size_t cells) {
  const auto masses = static_cast<std::size_t>(field.width());
  std::vector<std::uint32_t> lit;
  lit.reserve(cells);
  for (std::size_t i = 0; i < cells; ++i) {
    const float* e = &field.values[i * masses];
    if (std::any_of(e, e + masses, [](float value) { return value > 0; })) lit.push_back(static_cast<std::uint32_t>(i));
  }
  return lit;
}

/// The lit cells along the Morton curve of their centroids.
std::vector<MortonKey> leaf_order(const SurfaceCells& cells, const std::vector<std::uint32_t>& lit) {
  std::vector<glm::vec3> centroids(lit.size());
  tbb::parallel_for(std::size_t{0}, (lit.size() + 4095) / 4096, [&](std::size_t chunk) {
    for (std::size_t i = chunk * 4096; i < std::min(lit.size(), (chunk + 1) * 4096); ++i)
      centroids[i] = cell_centroid(cells[lit[i]]);
  });
  std::vector<MortonKey> order = morton_sorted(centroids);
  for (MortonKey& key : order) key.index = lit[key.index];
  return order;
}

}  // namespace

ClusterTree build_cluster_tree(const SurfaceCells& cells, const IrradianceField& irradiance) {
  ClusterTree tree;
  tree.masses = irradiance.width();
  const auto masses = static_cast<std::size_t>(tree.masses);
  tree.total_mass.assign(masses, 0.0);
  const std::vector<std::uint32_t> lit = lit_cells(irradiance, cells.size());
  for (const std::uint32_t i : lit)
    for (std::size_t m = 0; m < masses; ++m)
      tree.total_mass[m] +=
          static_cast<double>(irradiance.values[i * masses + m]) * static_cast<double>(cell_area(cells[i]));
  tree.dark_cells = cells.size() - lit.size();
  if (lit.empty()) return tree;
  const std::size_t nodes = 2 * lit.size() - 1;
  tree.nodes.resize(nodes);
  tree.mass.assign(nodes * masses, 0.0f);
  Builder builder{cells, irradiance, tree, leaf_order(cells, lit)};
  if (masses > 1) {
    tree.first_moment.assign(nodes * 3 * masses, 0.0f);
    builder.lowest.resize(nodes * masses);
    builder.highest.resize(nodes * masses);
  }
  builder.build(0, 0, lit.size());
  return tree;
}

}  // namespace opaline
