#include "render/subsurface/surface_frame.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

namespace opaline {
namespace {

constexpr double least_cosine = 0.17;  ///< of a plane's normal with the vertex normal: 80 degrees

/// Points in the cells of a grid as wide as the search radius, sorted by cell.
class PointGrid {
 public:
  PointGrid(const std::vector<glm::vec3>& points, double radius) : radius_(radius) {
    glm::dvec3 hi(-1e300);
    for (const glm::vec3& p : points) low_ = glm::min(low_, glm::dvec3(p)), hi = glm::max(hi, glm::dvec3(p));
    const glm::dvec3 size = hi - low_;
    // No more than 256 cells a side, however small the radius.
    width_ = std::max({radius, size.x / 256, size.y / 256, size.z / 256, 1e-30});
    count_ = glm::ivec3(size / width_) + 1;
    first_.assign(
        static_cast<std::size_t>(count_.x) * static_cast<std::size_t>(count_.y) * static_cast<std::size_t>(count_.z) +
            1,
        0);
    for (const glm::vec3& p : points) ++first_[cell(place(glm::dvec3(p))) + 1];
    for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
    sorted_.resize(points.size());
    std::vector<std::uint32_t> next(first_.begin(), first_.end() - 1);
    for (const glm::vec3& p : points) sorted_[next[cell(place(glm::dvec3(p)))]++] = glm::dvec3(p);
  }

  template <typename Visit>
  void for_each_within(const glm::dvec3& centre, Visit&& visit) const {
    const glm::ivec3 lo = place(centre - radius_), hi = place(centre + radius_);
    for (int z = lo.z; z <= hi.z; ++z)
      for (int y = lo.y; y <= hi.y; ++y)
        for (std::uint32_t i = first_[cell({lo.x, y, z})]; i < first_[cell({hi.x, y, z}) + 1]; ++i) {
          const glm::dvec3 d = sorted_[i] - centre;
          if (glm::dot(d, d) <= radius_ * radius_) visit(sorted_[i]);
        }
  }

 private:
  glm::ivec3 place(const glm::dvec3& p) const {
    return glm::clamp(glm::ivec3(glm::floor(glm::clamp((p - low_) / width_, -1.0, 1e6))), glm::ivec3(0), count_ - 1);
  }
  std::size_t cell(const glm::ivec3& at) const {
    return (static_cast<std::size_t>(at.z) * static_cast<std::size_t>(count_.y) + static_cast<std::size_t>(at.y)) *
               static_cast<std::size_t>(count_.x) +
           static_cast<std::size_t>(at.x);
  }

  double radius_, width_ = 1;
  glm::dvec3 low_{1e300};
  glm::ivec3 count_{1};
  std::vector<std::uint32_t> first_;
  std::vector<glm::dvec3> sorted_;
};

/// Each place once: seams repeat vertices.
std::vector<glm::vec3> distinct(std::vector<glm::vec3> points) {
  const auto key = [](const glm::vec3& p) { return std::array{p.x, p.y, p.z}; };
  std::sort(points.begin(), points.end(), [&](const glm::vec3& a, const glm::vec3& b) { return key(a) < key(b); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

/// Eigenvectors (columns) and eigenvalues of a symmetric matrix by Jacobi's rotations.
struct Eigen3 {
  glm::dmat3 vectors{1};
  glm::dvec3 values{0};
};
Eigen3 eigen(glm::dmat3 m) {
  Eigen3 e;
  for (int sweep = 0; sweep < 12; ++sweep)
    for (const auto& [p, q] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)}) {
      if (m[p][q] == 0) continue;
      const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
      const double t = std::copysign(1.0, theta) / (std::abs(theta) + std::hypot(theta, 1.0));
      const double c = 1 / std::hypot(t, 1.0), s = t * c;
      glm::dmat3 turn(1);
      turn[p][p] = turn[q][q] = c, turn[q][p] = s, turn[p][q] = -s;
      m = glm::transpose(turn) * m * turn;
      e.vectors = e.vectors * turn;
    }
  e.values = {m[0][0], m[1][1], m[2][2]};
  return e;
}

struct Plane {
  glm::dvec3 normal;
  double height;
};

/// The least-squares plane round a vertex, if there is one.
std::optional<Plane> fitted_plane(const PointGrid& grid, const glm::dvec3& vertex, const glm::dvec3& normal,
                                  double radius, std::uint64_t& neighbours) {
  glm::dvec3 sum(0);
  glm::dmat3 squares(0);
  std::uint64_t count = 0;
  grid.for_each_within(vertex, [&](const glm::dvec3& p) {
    const glm::dvec3 d = (p - vertex) / radius;  // of order 1: the sums keep their digits
    ++count;
    sum += d;
    squares += glm::outerProduct(d, d);
  });
  neighbours += count;
  if (count < 3) return std::nullopt;
  const double n = static_cast<double>(count);
  const glm::dvec3 centre = sum / n;
  const Eigen3 e = eigen(squares / n - glm::outerProduct(centre, centre));
  int order[3] = {0, 1, 2};
  std::sort(order, order + 3, [&](int a, int b) { return e.values[a] < e.values[b]; });
  if (!(e.values[order[1]] > 1e-9 * e.values[order[2]]) || !(e.values[order[2]] > 0)) return std::nullopt;
  glm::dvec3 up = glm::normalize(e.vectors[order[0]]);
  if (glm::dot(up, normal) < 0) up = -up;
  const double cosine = glm::dot(up, normal);
  if (!(cosine > least_cosine)) return std::nullopt;
  return Plane{up, std::clamp(radius * glm::dot(up, centre) / cosine, -radius, radius)};
}

/// Of u and v over a triangle [1/mm], times its area: zero where texture space has none.
struct Gradients {
  glm::dvec3 u{0}, v{0};
  double area = 0;
};
Gradients triangle_gradients(const Mesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]), ab = glm::dvec3(mesh.positions[t.y]) - a,
                                           ac = glm::dvec3(mesh.positions[t.z]) - a;
  const glm::dvec2 uv(mesh.uvs[t.x]), uv_b = glm::dvec2(mesh.uvs[t.y]) - uv, uv_c = glm::dvec2(mesh.uvs[t.z]) - uv;
  const glm::dvec3 n = glm::cross(ab, ac);
  const double square = glm::dot(n, n);
  if (!(square > 0)) return {};
  // The plane's vectors that are 1 on one edge and 0 on the other.
  const glm::dvec3 along_b = glm::cross(ac, n) / square, along_c = glm::cross(n, ab) / square;
  const double area = std::sqrt(square) / 2;
  return {area * (uv_b.x * along_b + uv_c.x * along_c), area * (uv_b.y * along_b + uv_c.y * along_c), area};
}

void add_gradients(const Mesh& mesh, SurfaceFrames& frames) {
  const std::size_t count = mesh.positions.size();
  std::vector<Gradients> sums(count);
  for (const glm::uvec3& t : mesh.triangles) {
    const Gradients g = triangle_gradients(mesh, t);
    for (int i = 0; i < 3; ++i) {
      Gradients& sum = sums[t[i]];
      sum.u += g.u, sum.v += g.v, sum.area += g.area;
    }
  }
  for (const Gradients& g : sums) {
    const double per_area = g.area > 0 ? 1 / g.area : 0;
    frames.gradient_u.emplace_back(g.u * per_area), frames.gradient_v.emplace_back(g.v * per_area);
    frames.without_gradient += glm::length(glm::cross(g.u, g.v)) <= 1e-20 * g.area * g.area;
  }
}

std::vector<glm::vec3> vertex_normals(const Mesh& mesh) {
  if (!mesh.normals.empty()) return mesh.normals;
  std::vector<glm::vec3> normals(mesh.positions.size(), glm::vec3(0));
  for (const glm::uvec3& t : mesh.triangles)
    for (int i = 0; i < 3; ++i)
      normals[t[i]] += glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]);
  for (glm::vec3& n : normals) n = glm::dot(n, n) > 0 ? glm::normalize(n) : glm::vec3(0, 0, 1);
  return normals;
}

}  // namespace

SurfaceFrames make_surface_frames(const Mesh& mesh, double radius) {
  SurfaceFrames frames;
  const std::size_t count = mesh.positions.size();
  frames.plane_normal = vertex_normals(mesh);
  frames.plane_height.assign(count, 0);
  const PointGrid grid(distinct(mesh.positions), radius);
  std::atomic<std::uint64_t> neighbours = 0, without_plane = 0;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 64), [&](const auto& range) {
    std::uint64_t met = 0, failed = 0;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const auto plane =
          fitted_plane(grid, glm::dvec3(mesh.positions[i]), glm::dvec3(frames.plane_normal[i]), radius, met);
      failed += !plane;
      if (plane)
        frames.plane_normal[i] = glm::vec3(plane->normal), frames.plane_height[i] = static_cast<float>(plane->height);
    }
    neighbours += met, without_plane += failed;
  });
  frames.neighbours = neighbours, frames.without_plane = without_plane;
  add_gradients(mesh, frames);
  return frames;
}

FramedPoint framed_point(const Mesh& mesh, const SurfaceFrames& frames, const VisiblePoint& p) {
  const glm::uvec3 t = mesh.triangles[p.triangle];
  const glm::vec3 a = mesh.positions[t.x], ab = mesh.positions[t.y] - a, ac = mesh.positions[t.z] - a;
  const glm::vec3 n = glm::cross(ab, ac), d = p.position - a;
  const float area2 = glm::dot(n, n);
  const float v = glm::dot(glm::cross(d, ac), n) / area2, w = glm::dot(glm::cross(ab, d), n) / area2, u = 1 - v - w;
  const auto mix = [&](const auto& values) { return u * values[t.x] + v * values[t.y] + w * values[t.z]; };
  FramedPoint f{p.position,
                p.normal,
                p.w_o,
                mix(frames.plane_normal),
                mix(frames.plane_height),
                mix(mesh.uvs),
                mix(frames.gradient_u),
                mix(frames.gradient_v)};
  const float length = glm::length(f.plane_normal);
  f.plane_normal = length > 1e-6f ? f.plane_normal / length : f.normal;
  return f;
}

}  // namespace opaline
