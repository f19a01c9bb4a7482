#include "render/transfer/reference_fit.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

namespace opaline {
namespace {

using Lanes = std::array<float, Remainder::lanes>;

double sum_of(const Lanes& lanes) { return std::accumulate(lanes.begin(), lanes.end(), 0.0); }

using Triangle = std::array<std::size_t, 3>;  ///< vertices

Triangle vertices_of(const ReferenceMesh& mesh, std::uint32_t triangle) {
  const glm::uvec3 t = mesh.triangles[triangle];
  return {mesh.points[t.x], mesh.points[t.y], mesh.points[t.z]};
}

/// A vertex and how its errors count.
class Query {
 public:
  Query(const Remainder& remainder, std::size_t vertex)
      : remainder_(remainder), vertex_(vertex), factor_(remainder.each(), 0.0f) {
    constexpr float dark = 0.03f, least = 0.02f;
    const float* value = remainder.value(vertex);
    const float largest = remainder.largest(vertex), one = largest > 0 ? 1 / largest : 0;
    for (std::size_t k = 0; k < factor_.size(); ++k) factor_[k] = dark / (std::abs(value[k]) * one + least);
  }

  /// Sum of squares of what a combination of a triangle's corners leaves.
  double left(const Triangle& t, const glm::dvec2& weights) const {
    const glm::vec3 w(weights, 1 - weights.x - weights.y);
    Lanes sum{};
    for_both(t, [&](float own, float a, float b, float c, float factor, std::size_t i) {
      const float left = factor * (own - w.x * a - w.y * b - w.z * c);
      sum[i] += left * left;
    });
    return sum_of(sum);
  }

  /// Least squares, two unknowns: weights of the first two of three corners, the third having the rest of 1.
  glm::dvec2 best_weights(const Triangle& t, const glm::dvec2& before) const {
    Lanes aa{}, ab{}, bb{}, ay{}, by{};
    for_both(t, [&](float own, float first, float second, float third, float factor, std::size_t i) {
      const float a = factor * (first - third), b = factor * (second - third), y = factor * (own - third);
      aa[i] += a * a, ab[i] += a * b, bb[i] += b * b, ay[i] += a * y, by[i] += b * y;
    });
    // A little pull towards what place says, where corners are alike.
    const double pull = 1e-4 * (sum_of(aa) + sum_of(bb)) + 1e-30;
    const double AA = sum_of(aa) + pull, BB = sum_of(bb) + pull, AB = sum_of(ab);
    const double AY = sum_of(ay) + pull * before.x, BY = sum_of(by) + pull * before.y;
    const double determinant = AA * BB - AB * AB;
    if (!(determinant > 0)) return before;
    const glm::dvec2 w((AY * BB - BY * AB) / determinant, (BY * AA - AY * AB) / determinant);
    return glm::clamp(w, glm::dvec2(-1), glm::dvec2(2));
  }

 private:
  /// Calls use(own, of the corners, factor, lane) for what the harmonics leave and for the values.
  template <typename Use>
  void for_both(const Triangle& t, const Use& use) const {
    const float *own = remainder_.rest(vertex_), *a = remainder_.rest(t[0]), *b = remainder_.rest(t[1]),
                *c = remainder_.rest(t[2]);
    const std::size_t each = remainder_.each();
    for (std::size_t k = 0; k < each; k += Remainder::lanes)
      for (std::size_t i = 0; i < Remainder::lanes; ++i) use(own[k + i], a[k + i], b[k + i], c[k + i], 1.0f, i);
    own += each, a += each, b += each, c += each;
    for (std::size_t k = 0; k < each; k += Remainder::lanes)
      for (std::size_t i = 0; i < Remainder::lanes; ++i)
        use(own[k + i], a[k + i], b[k + i], c[k + i], factor_[k + i], i);
  }

  const Remainder& remainder_;
  std::size_t vertex_;
  std::vector<float> factor_;
};

/// Splits triangles of a reference mesh where most is left.
class Splitter {
 public:
  Splitter(const Remainder& remainder, ReferenceMesh& mesh)
      : remainder_(remainder), mesh_(mesh), left_(mesh.triangle_of.size()), is_point_(mesh.triangle_of.size()) {
    for (const std::uint32_t v : mesh.points) is_point_[v] = true;
    tbb::parallel_for(std::size_t{0}, left_.size(),
                      [&](std::size_t v) { left_[v] = squares_left(remainder, mesh, v); });
    parts_.resize(mesh.triangles.size());
    for (std::uint32_t v = 0; v < left_.size(); ++v) parts_[mesh.triangle_of[v]].members.push_back(v);
    for (std::uint32_t t = 0; t < parts_.size(); ++t) add_up(t);
  }

  void split_until(std::size_t points) {
    while (mesh_.points.size() < points && !worst_.empty()) {
      const auto [left, triangle] = worst_.top();
      worst_.pop();
      if (left == parts_[triangle].left) split(triangle);  // else it has been split meanwhile
    }
  }

 private:
  /// A triangle's vertices, what is left of them, and the one of which most is.
  struct Part {
    std::vector<std::uint32_t> members;
    double left = 0;
    std::uint32_t worst = 0;
  };

  double left_in(std::size_t v, std::uint32_t triangle, const glm::dvec2& weights) const {
    return Query(remainder_, v).left(vertices_of(mesh_, triangle), weights);
  }

  void add_up(std::uint32_t triangle) {
    Part& part = parts_[triangle];
    double most = 0;
    part.left = 0;
    for (const std::uint32_t v : part.members) {
      part.left += left_[v];
      if (!is_point_[v] && left_[v] > most) most = left_[v], part.worst = v;
    }
    if (most > 0) worst_.emplace(part.left, triangle);
  }

  /// The triangle with a new point in place of corner k; the first takes the place of the triangle itself.
  std::uint32_t with_corner(std::uint32_t triangle, bool in_place, const glm::uvec3& corners, int k,
                            std::uint32_t point) {
    if (!in_place) {
      triangle = static_cast<std::uint32_t>(parts_.size());
      parts_.emplace_back();
      mesh_.triangles.emplace_back();
    }
    mesh_.triangles[triangle] = corners;
    mesh_.triangles[triangle][k] = point;
    return triangle;
  }

  void split(std::uint32_t triangle) {
    const std::uint32_t v = parts_[triangle].worst, point = static_cast<std::uint32_t>(mesh_.points.size());
    const glm::uvec3 corners = mesh_.triangles[triangle];
    const glm::dvec3 p(mesh_.weights[v], 1 - mesh_.weights[v].x - mesh_.weights[v].y);
    mesh_.points.push_back(v), is_point_[v] = true;
    std::vector<std::uint32_t> members;
    members.swap(parts_[triangle].members);
    constexpr double inside = 1e-6;
    const int sides = (p.x > inside) + (p.y > inside) + (p.z > inside);
    std::array<std::uint32_t, 3> part{triangle, triangle, triangle};
    for (int k = 0, made = sides == 1; k < 3; ++k)  // at a corner the triangle stays beside its only part
      if (p[k] > inside) part[static_cast<std::size_t>(k)] = with_corner(triangle, made++ == 0, corners, k, point);
    for (const std::uint32_t m : members) move(m, p, part, sides == 1);
    for (const std::uint32_t m : members) parts_[mesh_.triangle_of[m]].members.push_back(m);
    add_up(triangle);
    for (const std::uint32_t t : part)
      if (t != triangle) add_up(t);
  }

  /// To the part that a vertex lies in; where there is a choice, to where less is left.
  void move(std::uint32_t v, const glm::dvec3& p, const std::array<std::uint32_t, 3>& part, bool choice) {
    const glm::dvec3 w(mesh_.weights[v], 1 - mesh_.weights[v].x - mesh_.weights[v].y);
    int corner = -1;
    for (int k = 0; k < 3; ++k)
      if (p[k] > 1e-6 && (corner < 0 || w[k] * p[corner] < w[corner] * p[k])) corner = k;
    const double share = w[corner] / p[corner];
    glm::dvec3 inner = w - share * p;
    inner[corner] = share;
    const std::uint32_t to = part[static_cast<std::size_t>(corner)];
    const double left = left_in(v, to, inner);
    if (choice && left >= left_[v]) return;
    mesh_.triangle_of[v] = to, mesh_.weights[v] = inner, left_[v] = left;
  }

  const Remainder& remainder_;
  ReferenceMesh& mesh_;
  std::vector<double> left_;  ///< of each vertex, squared
  std::vector<bool> is_point_;
  std::vector<Part> parts_;
  std::priority_queue<std::pair<double, std::uint32_t>> worst_;
};

/// The triangles at each point.
std::vector<std::vector<std::uint32_t>> triangles_around(const ReferenceMesh& mesh) {
  std::vector<std::vector<std::uint32_t>> around(mesh.points.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) around[mesh.triangles[t][k]].push_back(t);
  return around;
}

}  // namespace

Remainder::Remainder(const TransferTable& table, const HarmonicFit& fit)
    : each_((table.rows() + lanes - 1) / lanes * lanes),
      values_(2 * each_ * table.vertices, 0.0f),
      largest_(table.vertices, 0.0f) {
  TransferTable rest = table;
  fit.subtract(fit.coefficients(table), rest);
  constexpr std::size_t block = 64;
  tbb::parallel_for(std::size_t{0}, (table.vertices + block - 1) / block, [&](std::size_t b) {
    for (std::size_t r = 0; r < table.rows(); ++r)
      for (std::size_t v = b * block; v < std::min((b + 1) * block, table.vertices); ++v) {
        values_[2 * v * each_ + r] = rest.row(r)[v];
        values_[(2 * v + 1) * each_ + r] = table.row(r)[v];
        largest_[v] = std::max(largest_[v], std::abs(table.row(r)[v]));
      }
  });
}

double squares_left(const Remainder& remainder, const ReferenceMesh& mesh, std::size_t vertex) {
  return Query(remainder, vertex).left(vertices_of(mesh, mesh.triangle_of[vertex]), mesh.weights[vertex]);
}

void add_points(const Remainder& remainder, std::size_t points, ReferenceMesh& mesh) {
  Splitter(remainder, mesh).split_until(points);
}

void fit_weights(const Remainder& remainder, ReferenceMesh& mesh) {
  const std::vector<std::vector<std::uint32_t>> around = triangles_around(mesh);
  tbb::parallel_for(std::size_t{0}, remainder.vertices(), [&](std::size_t v) {
    const Query query(remainder, v);
    const std::uint32_t own = mesh.triangle_of[v];
    std::vector<std::uint32_t> tried;
    for (int k = 0; k < 3; ++k)
      for (const std::uint32_t t : around[mesh.triangles[own][k]]) tried.push_back(t);
    std::sort(tried.begin(), tried.end());
    tried.erase(std::unique(tried.begin(), tried.end()), tried.end());
    double least = std::numeric_limits<double>::infinity();
    const glm::dvec2 place = mesh.weights[v];
    for (const std::uint32_t t : tried) {
      const Triangle corners = vertices_of(mesh, t);
      const glm::dvec2 w = query.best_weights(corners, t == own ? place : glm::dvec2(1.0 / 3));
      const double left = query.left(corners, w);
      if (left < least) least = left, mesh.triangle_of[v] = t, mesh.weights[v] = w;
    }
  });
}

}  // namespace opaline
