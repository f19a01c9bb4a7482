#include "datasets_synthetic/shapes/zero_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <utility>

namespace opaline {
namespace {

/// Lattice points: corners (i, j, k) of the cubes and their centres. Values are computed only in
/// blocks of cubes that the zero set may cross; elsewhere they stay NaN.
class Lattice {
 public:
  Lattice(const Field& field, const Box& box, double cell) : field_(field), lo_(box.lo), cell_(cell) {
    cubes_ = glm::ivec3(glm::ceil((box.hi - box.lo) / cell));
    corners_ = static_cast<std::int64_t>(cubes_.x + 1) * (cubes_.y + 1) * (cubes_.z + 1);
    values_.assign(corners_ + static_cast<std::int64_t>(cubes_.x) * cubes_.y * cubes_.z,
                   std::numeric_limits<double>::quiet_NaN());
    for_each_near_block([&](glm::ivec3 lo, glm::ivec3 hi) { evaluate(lo, hi); });
  }

  glm::ivec3 cubes() const { return cubes_; }
  std::int64_t corner(glm::ivec3 c) const {
    return (static_cast<std::int64_t>(c.z) * (cubes_.y + 1) + c.y) * (cubes_.x + 1) + c.x;
  }
  std::int64_t centre(glm::ivec3 c) const {
    return corners_ + (static_cast<std::int64_t>(c.z) * cubes_.y + c.y) * cubes_.x + c.x;
  }
  double value(std::int64_t id) const { return values_[id]; }
  glm::dvec3 position(std::int64_t id) const {
    const bool is_centre = id >= corners_;
    const glm::ivec3 n = cubes_ + (is_centre ? 0 : 1);
    const std::int64_t i = is_centre ? id - corners_ : id;
    const glm::dvec3 c(i % n.x, i / n.x % n.y, i / n.x / n.y);
    return lo_ + cell_ * (c + (is_centre ? 0.5 : 0.0));
  }

 private:
  template <typename Visit>
  void for_each_near_block(const Visit& visit) const {
    constexpr int size = 6;
    const double radius = 0.5 * std::sqrt(3.0) * size * cell_;
    glm::ivec3 b;
    for (b.z = 0; b.z < cubes_.z; b.z += size)
      for (b.y = 0; b.y < cubes_.y; b.y += size)
        for (b.x = 0; b.x < cubes_.x; b.x += size) {
          const double d = field_(lo_ + cell_ * (glm::dvec3(b) + 0.5 * size));
          if (std::abs(d) < 1.8 * radius) visit(b, glm::min(b + size, cubes_));
        }
  }
  void evaluate(glm::ivec3 lo, glm::ivec3 hi) {
    const auto fill = [&](std::int64_t id) {
      if (std::isnan(values_[id])) values_[id] = field_(position(id));
    };
    glm::ivec3 c;
    for (c.z = lo.z; c.z <= hi.z; ++c.z)
      for (c.y = lo.y; c.y <= hi.y; ++c.y)
        for (c.x = lo.x; c.x <= hi.x; ++c.x) {
          fill(corner(c));
          if (c.x < hi.x && c.y < hi.y && c.z < hi.z) fill(centre(c));
        }
  }
  const Field& field_;
  glm::dvec3 lo_;
  double cell_;
  glm::ivec3 cubes_;
  std::int64_t corners_;
  std::vector<double> values_;
};

class Marcher {
 public:
  Marcher(const Field& field, const Lattice& lattice) : field_(field), lattice_(lattice) {}

  void tetrahedron(const std::array<std::int64_t, 4>& corners) {
    std::array<std::int64_t, 4> in{}, out{};
    int ins = 0, outs = 0;
    for (const std::int64_t id : corners) {
      const double value = lattice_.value(id);
      if (std::isnan(value)) return;
      (value < 0 ? in[ins++] : out[outs++]) = id;
    }
    if (ins == 1) triangle({in[0], out[0]}, {in[0], out[1]}, {in[0], out[2]});
    if (ins == 3) triangle({in[0], out[0]}, {in[1], out[0]}, {in[2], out[0]});
    if (ins == 2) {
      triangle({in[0], out[0]}, {in[0], out[1]}, {in[1], out[1]});
      triangle({in[0], out[0]}, {in[1], out[1]}, {in[1], out[0]});
    }
  }
  RawMesh take() { return std::move(mesh_); }

 private:
  using Edge = std::pair<std::int64_t, std::int64_t>;  // inside end, outside end

  unsigned vertex(const Edge& e) {
    const std::uint64_t a = std::min(e.first, e.second), b = std::max(e.first, e.second);
    const auto [slot, is_new] = vertices_.try_emplace(a << 32 | b, static_cast<unsigned>(mesh_.positions.size()));
    if (is_new) mesh_.positions.push_back(crossing(e));
    return slot->second;
  }
  /// Bisects before it interpolates: inside a thin sheet the field turns around, and a straight line
  /// through the two ends would put the vertex under the wrong face. The point stays away from the
  /// ends, so that no triangle starts out degenerate.
  glm::dvec3 crossing(const Edge& e) const {
    const glm::dvec3 in = lattice_.position(e.first), out = lattice_.position(e.second);
    double t0 = 0, t1 = 1, d0 = lattice_.value(e.first), d1 = lattice_.value(e.second);
    for (int step = 0; step < 3; ++step) {
      const double t = 0.5 * (t0 + t1), d = field_((1 - t) * in + t * out);
      (d < 0 ? t0 : t1) = t;
      (d < 0 ? d0 : d1) = d;
    }
    const double t = std::clamp(t0 + (t1 - t0) * d0 / (d0 - d1), 0.05, 0.95);
    return (1 - t) * in + t * out;
  }
  /// The triangle's plane parts the two ends of each of its edges: that tells its outside.
  void triangle(const Edge& e0, const Edge& e1, const Edge& e2) {
    const unsigned a = vertex(e0), b = vertex(e1), c = vertex(e2);
    const auto& p = mesh_.positions;
    const glm::dvec3 outwards = lattice_.position(e0.second) - lattice_.position(e0.first);
    const bool turned = glm::dot(glm::cross(p[b] - p[a], p[c] - p[a]), outwards) < 0;
    mesh_.triangles.push_back(turned ? glm::uvec3(a, c, b) : glm::uvec3(a, b, c));
  }
  const Field& field_;
  const Lattice& lattice_;
  RawMesh mesh_;
  std::unordered_map<std::uint64_t, unsigned> vertices_;
};

/// The four tetrahedra around the segment between the centres of cubes c and c + e(axis).
void march_across_face(const Lattice& lattice, Marcher& marcher, glm::ivec3 c, int axis) {
  glm::ivec3 step(0), u(0), v(0);
  step[axis] = u[(axis + 1) % 3] = v[(axis + 2) % 3] = 1;
  const glm::ivec3 base = c + step;
  const std::int64_t ring[4] = {lattice.corner(base), lattice.corner(base + u), lattice.corner(base + u + v),
                                lattice.corner(base + v)};
  for (int i = 0; i < 4; ++i)
    marcher.tetrahedron({lattice.centre(c), lattice.centre(c + step), ring[i], ring[(i + 1) % 4]});
}

}  // namespace

FieldSample sample_field(const Field& field, const glm::dvec3& p) {
  constexpr double h = 1e-4;  // in the field's units; small against any detail, large against rounding
  static const glm::dvec3 axes[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  FieldSample result{0, glm::dvec3(0)};
  for (const glm::dvec3& axis : axes) {
    const double value = field(p + h * axis);
    result.value += value / 4;
    result.gradient += axis * (value / (4 * h));
  }
  return result;
}

RawMesh extract_zero_set(const Field& field, const Box& box, double cell) {
  const Lattice lattice(field, box, cell);
  Marcher marcher(field, lattice);
  glm::ivec3 c;
  for (c.z = 0; c.z < lattice.cubes().z; ++c.z)
    for (c.y = 0; c.y < lattice.cubes().y; ++c.y)
      for (c.x = 0; c.x < lattice.cubes().x; ++c.x) {
        if (std::isnan(lattice.value(lattice.centre(c)))) continue;
        for (int axis = 0; axis < 3; ++axis)
          if (c[axis] + 1 < lattice.cubes()[axis]) march_across_face(lattice, marcher, c, axis);
      }
  return marcher.take();
}

}  // namespace opaline
