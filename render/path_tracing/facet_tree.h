// Finds every facet through which light reaches a point inside by refraction. A mesh has thousands of facets and a
// point sees the light through a handful of them.
//
// A node holds a ball around its facets and a cone around their normals. Let u(n, l) be the direction inside towards a
// facet of normal n and a light in direction l. For eta >= 1, turning n by an angle turns u by no more than it, and so
// does turning l (the deviation theta_i - theta_t grows with theta_i, slower than it). With the node's mean normal n0
// and l0 at its centre, every facet of the node has its u within beta + 2 delta of u(n0, l0), where beta is the cone's
// half-angle and delta the ball's half-angle seen from the light (0 for a far one). A ray from y that hits the node
// is within alpha, the ball's half-angle seen from y, of the direction to its centre. If these two cones don't meet,
// no facet of the node can be a solution. For eta < 1 u may turn faster; then only facets that face away are pruned.
#pragma once

#include "render/path_tracing/facet.h"
#include "render/scene/mesh.h"

#include <cstdint>
#include <vector>

namespace opaline {

std::vector<Facet> facets_of(const Mesh& mesh);

struct SearchCounts {
  std::uint64_t nodes = 0, facets = 0, rays_found = 0;
};

class FacetTree {
 public:
  FacetTree() = default;
  explicit FacetTree(std::vector<Facet> facets);

  /// In the order of the mesh.
  const std::vector<Facet>& facets() const { return facets_; }

  /// Calls visit(RefractedRay, Facet) for each facet with one whose length inside is at most `reach`, whether or not
  /// something is in its way.
  template <typename Visit>
  void for_each_ray(const PointOrDirection& light, const glm::dvec3& y, double eta, double reach, SearchCounts& counts,
                    Visit&& visit) const {
    std::uint32_t stack[64];
    int top = 0;
    if (!nodes_.empty()) stack[top++] = 0;
    while (top > 0) {
      const Node& node = nodes_[stack[--top]];
      ++counts.nodes;
      const double near = reach + node.radius;
      const glm::dvec3 to_node = node.centre - y;
      if (glm::dot(to_node, to_node) > near * near || !may_hold_ray(node, light, to_node, eta)) continue;
      if (node.count == 0) {
        stack[top++] = node.first;
        stack[top++] = node.first + 1;
        continue;
      }
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        ++counts.facets;
        const auto ray = refracted_ray(facets_[order_[i]], light, y, eta);
        if (ray && ray->length <= reach) {
          ++counts.rays_found;
          visit(*ray, facets_[order_[i]]);
        }
      }
    }
  }

  /// Sums of values (one per facet, >= 0) over each node, for `draw`.
  std::vector<double> node_sums(const std::vector<double>& values) const;
  /// Draws a facet with a probability that grows with its value and falls with its distance d from a place, about as
  /// 1/(d^2 + scale^2): from the root on, a child is taken by what its sum is worth there. Facets of value 0 are never
  /// drawn; the values must not all be 0.
  struct Drawn {
    std::uint32_t facet;
    double probability;
  };
  Drawn draw(const std::vector<double>& values, const std::vector<double>& sums, const glm::dvec3& place, double scale,
             double xi) const;

 private:
  struct Node {
    glm::dvec3 centre, axis;
    double radius, cos_beta, sin_beta;
    std::uint32_t first, count;  // facets of a leaf in `order_`; count 0: its two children stand at `first`
  };
  static bool may_hold_ray(const Node& node, const PointOrDirection& light, const glm::dvec3& to_node, double eta);
  void build(std::uint32_t node, std::uint32_t first, std::uint32_t count);
  void bound(Node& node, std::uint32_t first, std::uint32_t count) const;

  std::vector<Facet> facets_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace opaline
