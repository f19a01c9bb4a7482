#include "render/transfer/transfer_tree.h"

#include <tbb/parallel_invoke.h>

#include <algorithm>

namespace opaline {

TransferTree::TransferTree(const SurfaceCells& cells)
    : cells_(cells),
      tree_(build_cluster_tree(cells, {1, 1, Rgb(1), std::vector<float>(cells.size(), 1.0f)})),
      inner_(tree_.nodes.size(), leaf) {
  std::uint32_t inner = 0;
  for (std::size_t i = 0; i < inner_.size(); ++i)
    if (!tree_.nodes[i].leaf()) inner_[i] = inner++;
  mass_.resize(inner_.size() * transfer_columns);
  moments_.resize(inner * 3 * transfer_columns);
}

void TransferTree::add_child(std::size_t node, std::size_t child) {
  const glm::vec3 d = tree_.nodes[child].centroid - tree_.nodes[node].centroid;
  float *mass = &mass_[node * transfer_columns], *moment = &moments_[inner_[node] * 3 * transfer_columns];
  const float *from = this->mass(child), *from_moment = moments(child);
  for (std::size_t k = 0; k < transfer_columns; ++k) mass[k] += from[k];
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (std::size_t k = 0; k < transfer_columns; ++k) {
      const std::size_t at = axis * transfer_columns + k;
      moment[at] += from[k] * d[static_cast<int>(axis)] + (from_moment ? from_moment[at] : 0);
    }
}

void TransferTree::fill_node(std::size_t node, const std::vector<float>& irradiance) {
  constexpr std::uint32_t parallel_size = 4096;
  const ClusterNode& n = tree_.nodes[node];
  float* mass = &mass_[node * transfer_columns];
  if (n.leaf()) {
    for (std::size_t k = 0; k < transfer_columns; ++k) mass[k] = n.area * irradiance[n.cell * transfer_columns + k];
    return;
  }
  const std::size_t left = node + 1, right = tree_.nodes[left].skip;
  if (n.skip - node > parallel_size) {
    tbb::parallel_invoke([&] { fill_node(left, irradiance); }, [&] { fill_node(right, irradiance); });
  } else {
    fill_node(left, irradiance), fill_node(right, irradiance);
  }
  std::fill_n(mass, transfer_columns, 0.0f);
  std::fill_n(&moments_[inner_[node] * 3 * transfer_columns], 3 * transfer_columns, 0.0f);
  add_child(node, left), add_child(node, right);
}

void TransferTree::fill(const std::vector<float>& irradiance) {
  if (!tree_.nodes.empty()) fill_node(0, irradiance);
}

}  // namespace opaline
