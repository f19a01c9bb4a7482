#include "render/path_tracing/facet_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace opaline {
namespace {

constexpr std::uint32_t leaf_size = 2;

glm::dvec3 centroid(const Facet& f) { return f.at(1.0 / 3, 1.0 / 3); }

/// An angle in [0, pi] by cosine and sine; sums stop at pi.
struct Angle {
  double cosine = 1, sine = 0;

  Angle operator+(const Angle& b) const {
    const double s = sine * b.cosine + cosine * b.sine;
    if (s < 0 || cosine <= -1 || b.cosine <= -1) return {-1, 0};
    return {cosine * b.cosine - sine * b.sine, s};
  }
};

/// Half the angle at which a ball is seen; pi from inside.
Angle half_angle(double radius, double distance) {
  if (distance <= radius) return {-1, 0};
  const double s = radius / distance;
  return {std::sqrt((1 - s) * (1 + s)), s};
}

}  // namespace

std::vector<Facet> facets_of(const Mesh& mesh) {
  std::vector<Facet> facets;
  facets.reserve(mesh.triangles.size());
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    facets.push_back({a, b - a, c - a, glm::normalize(glm::cross(b - a, c - a))});
  }
  return facets;
}

FacetTree::FacetTree(std::vector<Facet> facets) : facets_(std::move(facets)), order_(facets_.size()) {
  if (facets_.empty()) return;
  std::iota(order_.begin(), order_.end(), 0u);
  nodes_.emplace_back();
  build(0, 0, static_cast<std::uint32_t>(order_.size()));
}

void FacetTree::build(std::uint32_t node, std::uint32_t first, std::uint32_t count) {
  bound(nodes_[node], first, count);
  if (count <= leaf_size) {
    nodes_[node].first = first;
    nodes_[node].count = count;
    return;
  }
  glm::dvec3 lo(std::numeric_limits<double>::max()), hi(-lo);
  for (std::uint32_t i = first; i < first + count; ++i) {
    lo = glm::min(lo, centroid(facets_[order_[i]]));
    hi = glm::max(hi, centroid(facets_[order_[i]]));
  }
  const glm::dvec3 size = hi - lo;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    return centroid(facets_[a])[axis] < centroid(facets_[b])[axis];
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.resize(nodes_.size() + 2);
  nodes_[node].first = children;
  nodes_[node].count = 0;
  build(children, first, count / 2);
  build(children + 1, first + count / 2, count - count / 2);
}

void FacetTree::bound(Node& node, std::uint32_t first, std::uint32_t count) const {
  glm::dvec3 lo(std::numeric_limits<double>::max()), hi(-lo), axis(0);
  const auto for_each_corner = [&](auto&& f) {
    for (std::uint32_t i = first; i < first + count; ++i) {
      const Facet& facet = facets_[order_[i]];
      for (const glm::dvec3& p : {facet.corner, facet.at(1, 0), facet.at(0, 1)}) f(p);
    }
  };
  for_each_corner([&](const glm::dvec3& p) { lo = glm::min(lo, p), hi = glm::max(hi, p); });
  for (std::uint32_t i = first; i < first + count; ++i) axis += facets_[order_[i]].normal;
  node.centre = (lo + hi) / 2.0;
  node.radius = 0;
  for_each_corner([&](const glm::dvec3& p) { node.radius = std::max(node.radius, glm::length(p - node.centre)); });
  node.axis = glm::length(axis) > 1e-9 ? glm::normalize(axis) : facets_[order_[first]].normal;
  double cosine = 1;
  for (std::uint32_t i = first; i < first + count; ++i)
    cosine = std::min(cosine, glm::dot(node.axis, facets_[order_[i]].normal));
  node.cos_beta = std::max(-1.0, cosine - 1e-12);
  node.sin_beta = std::sqrt(std::max(0.0, (1 - node.cos_beta) * (1 + node.cos_beta)));
}

bool FacetTree::may_hold_ray(const Node& node, const PointOrDirection& light, const glm::dvec3& to_node, double eta) {
  if (!light.may_light(node.centre, node.radius)) return false;
  glm::dvec3 l = light.place;
  Angle delta, beta{node.cos_beta, node.sin_beta};
  if (!light.far) {
    const glm::dvec3 d = light.place - node.centre;
    const double distance = glm::length(d);
    delta = half_angle(node.radius, distance);
    if (distance > 0) l = d / distance;
  }
  const Angle spread = beta + delta;
  const double cosine = glm::dot(node.axis, l);
  if (spread.cosine > 0 && cosine < -spread.sine) return false;  // every facet faces away
  if (eta < 1) return true;
  const double distance = glm::length(to_node);
  Angle total = half_angle(node.radius, distance) + spread + delta;
  glm::dvec3 normal = node.axis;
  if (cosine < 0) {  // the nearest normal that is lit
    const glm::dvec3 horizon = node.axis - cosine * l;
    const double length = glm::length(horizon);
    if (length < 1e-9) return true;
    normal = horizon / length;
    total = total + Angle{length, -cosine};
  }
  if (total.sine <= 0 && total.cosine < 0) return true;
  // As direction_inside, which has no answer at grazing incidence for eta = 1; here it is the limit that counts.
  const double c = std::clamp(glm::dot(l, normal), 0.0, 1.0);
  const double cos_inside = std::sqrt(std::max(0.0, 1 - (1 - c) * (1 + c) / (eta * eta)));
  const glm::dvec3 u = l / eta + (cos_inside - c / eta) * normal;
  return glm::dot(u, to_node) >= (total.cosine - 1e-9) * distance;
}

std::vector<double> FacetTree::node_sums(const std::vector<double>& values) const {
  std::vector<double> sums(nodes_.size());
  for (std::size_t i = nodes_.size(); i-- > 0;) {  // children stand behind their parent
    const Node& node = nodes_[i];
    if (node.count == 0) sums[i] = sums[node.first] + sums[node.first + 1];
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) sums[i] += values[order_[k]];
  }
  return sums;
}

FacetTree::Drawn FacetTree::draw(const std::vector<double>& values, const std::vector<double>& sums,
                                 const glm::dvec3& place, double scale, double xi) const {
  std::uint32_t at = 0;
  double probability = 1;
  // Takes the first of two with probability p and makes xi uniform again.
  const auto takes_first = [&](double p) {
    const bool first = xi < p;
    xi = first ? xi / p : (xi - p) / (1 - p);
    probability *= first ? p : 1 - p;
    return first;
  };
  while (nodes_[at].count == 0) {
    const auto worth = [&](std::uint32_t child) {
      const glm::dvec3 d = nodes_[child].centre - place;
      return sums[child] / (glm::dot(d, d) + nodes_[child].radius * nodes_[child].radius + scale * scale);
    };
    const double a = worth(nodes_[at].first), b = worth(nodes_[at].first + 1);
    at = nodes_[at].first + (takes_first(a / (a + b)) ? 0 : 1);
  }
  std::uint32_t k = nodes_[at].first;
  double rest = sums[at];
  for (const std::uint32_t last = k + nodes_[at].count - 1; k < last; ++k) {
    if (takes_first(values[order_[k]] / rest)) break;
    rest -= values[order_[k]];
  }
  return {order_[k], probability};
}

}  // namespace opaline
