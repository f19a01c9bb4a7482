#include "render/irradiance/cluster_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <numeric>

namespace opaline {
namespace {

struct Builder {
  const SurfaceCells& cells;
  const IrradianceField& field;
  ClusterTree& tree;
  std::vector<std::uint32_t> order;  // lit cells, permuted into leaf order
  std::vector<glm::vec3> centroids;  // per cell
  static constexpr std::size_t parallel_size = 4096;

  std::size_t masses() const { return static_cast<std::size_t>(tree.masses); }

  void make_leaf(std::size_t node_index, std::uint32_t cell_index) {
    const SurfaceCell& cell = cells[cell_index];
    ClusterNode& node = tree.nodes[node_index];
    node.centroid = centroids[cell_index];
    node.area = cell_area(cell);
    node.cell = cell_index;
    node.radius = 0;
    std::fill(std::begin(node.covariance), std::end(node.covariance), 0.0f);
    // Uniform triangle: second moment = sum over vertices of d d^T / 12.
    for (const glm::vec3& vertex : {cell.a, cell.b, cell.c}) {
      const glm::vec3 d = vertex - node.centroid;
      node.radius = std::max(node.radius, glm::length(d));
      add_outer(node.covariance, d, 1.0f / 12);
    }
    for (std::size_t m = 0; m < masses(); ++m)
      tree.mass[node_index * masses() + m] = field.values[cell_index * masses() + m] * node.area;
  }

  static void add_outer(float* covariance, const glm::vec3& d, float weight) {
    covariance[0] += weight * d.x * d.x, covariance[1] += weight * d.x * d.y, covariance[2] += weight * d.x * d.z;
    covariance[3] += weight * d.y * d.y, covariance[4] += weight * d.y * d.z, covariance[5] += weight * d.z * d.z;
  }

  float weight_of(std::size_t node) const {
    float sum = 0;
    for (std::size_t m = 0; m < masses(); ++m) sum += tree.mass[node * masses() + m];
    return sum;
  }

  void merge(std::size_t index, std::size_t left, std::size_t right) {
    ClusterNode& node = tree.nodes[index];
    const std::size_t child[2] = {left, right};
    const float w[2] = {weight_of(left), weight_of(right)};
    const float share[2] = {w[0] / (w[0] + w[1]), w[1] / (w[0] + w[1])};
    node.cell = ClusterNode::no_cell;
    node.centroid = share[0] * tree.nodes[left].centroid + share[1] * tree.nodes[right].centroid;
    node.area = tree.nodes[left].area + tree.nodes[right].area;
    std::fill(std::begin(node.covariance), std::end(node.covariance), 0.0f);
    for (int i = 0; i < 2; ++i) {
      const ClusterNode& c = tree.nodes[child[i]];
      const glm::vec3 d = c.centroid - node.centroid;
      for (int k = 0; k < 6; ++k) node.covariance[k] += share[i] * c.covariance[k];
      add_outer(node.covariance, d, share[i]);
      merge_masses(index, child[i], d);
    }
  }

  void merge_masses(std::size_t index, std::size_t child, const glm::vec3& d) {
    const std::size_t n = masses();
    for (std::size_t m = 0; m < n; ++m) {
      const float mass = tree.mass[child * n + m];
      tree.mass[index * n + m] += mass;
      if (n == 1) continue;
      for (std::size_t axis = 0; axis < 3; ++axis)
        tree.first_moment[(index * 3 + axis) * n + m] +=
            tree.first_moment[(child * 3 + axis) * n + m] + mass * d[static_cast<int>(axis)];
    }
  }

  float bounding_radius(const glm::vec3& centre, std::size_t begin, std::size_t end) const {
    float square = 0;
    for (std::size_t i = begin; i < end; ++i) {
      const SurfaceCell& cell = cells[order[i]];
      for (const glm::vec3& vertex : {cell.a, cell.b, cell.c})
        square = std::max(square, glm::dot(vertex - centre, vertex - centre));
    }
    return std::sqrt(square);
  }

  void build(std::size_t node, std::size_t begin, std::size_t end) {
    const std::size_t count = end - begin;
    tree.nodes[node].skip = static_cast<std::uint32_t>(node + 2 * count - 1);
    if (count == 1) return make_leaf(node, order[begin]);
    glm::vec3 lo(centroids[order[begin]]), hi(lo);
    for (std::size_t i = begin; i < end; ++i)
      lo = glm::min(lo, centroids[order[i]]), hi = glm::max(hi, centroids[order[i]]);
    const glm::vec3 size = hi - lo;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : (size.y >= size.z ? 1 : 2);
    const std::size_t middle = begin + count / 2;
    // Ties are broken by index: the tree depends on nothing but its input.
    std::nth_element(order.begin() + static_cast<std::ptrdiff_t>(begin),
                     order.begin() + static_cast<std::ptrdiff_t>(middle),
                     order.begin() + static_cast<std::ptrdiff_t>(end), [&](std::uint32_t i, std::uint32_t j) {
                       const float a = centroids[i][axis], b = centroids[j][axis];
                       return a != b ? a < b : i < j;
                     });
    const std::size_t left = node + 1, right = left + 2 * (middle - begin) - 1;
    if (count > parallel_size) {
      tbb::parallel_invoke([&] { build(left, begin, middle); }, [&] { build(right, middle, end); });
    } else {
      build(left, begin, middle);
      build(right, middle, end);
    }
    merge(node, left, right);
    tree.nodes[node].radius = bounding_radius(tree.nodes[node].centroid, begin, end);
  }
};

}  // namespace

ClusterTree build_cluster_tree(const SurfaceCells& cells, const IrradianceField& irradiance) {
  ClusterTree tree;
  tree.masses = irradiance.width();
  const auto masses = static_cast<std::size_t>(tree.masses);
  tree.total_mass.assign(masses, 0.0);
  Builder builder{cells, irradiance, tree, {}, {}};
  builder.centroids.resize(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    builder.centroids[i] = cell_centroid(cells[i]);
    const float* e = &irradiance.values[i * masses];
    if (std::any_of(e, e + masses, [](float value) { return value > 0; }))
      builder.order.push_back(static_cast<std::uint32_t>(i));
    for (std::size_t m = 0; m < masses; ++m)
      tree.total_mass[m] += static_cast<double>(e[m]) * static_cast<double>(cell_area(cells[i]));
  }
  tree.dark_cells = cells.size() - builder.order.size();
  if (builder.order.empty()) return tree;
  const std::size_t nodes = 2 * builder.order.size() - 1;
  tree.nodes.resize(nodes);
  tree.mass.assign(nodes * masses, 0.0f);
  if (masses > 1) tree.first_moment.assign(nodes * 3 * masses, 0.0f);
  builder.build(0, 0, builder.order.size());
  return tree;
}

}  // namespace opaline
