// Newell's control points, written by their structure. 24 of the 32 patches are surfaces of
// revolution (a ring of radius r has the control points r (1, 0), r (1, k), r (k, 1), r (0, 1) per
// quarter, k = 0.56), the other 8 are two tubes whose rings are given by two points in the plane of
// symmetry and a half width. Here z is up, as in his tables; points are turned to +y up at the end.
#include "datasets_synthetic/shapes/rings.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "model/check.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace opaline {
namespace {

constexpr double newell_height = 3.15;

struct Revolved {
  double r, z, k = 0.56;
};
constexpr std::array<std::array<Revolved, 4>, 2> lid{{{{{0, 3.15}, {0.8, 3.15, 0.45 / 0.8}, {0, 2.85}, {0.2, 2.7}}},
                                                      {{{0.2, 2.7}, {0.4, 2.55}, {1.3, 2.55}, {1.3, 2.4}}}}};
constexpr std::array<std::array<Revolved, 4>, 4> body{{{{{1.4, 2.4}, {1.3375, 2.53125}, {1.4375, 2.53125}, {1.5, 2.4}}},
                                                       {{{1.5, 2.4}, {1.75, 1.875}, {2, 1.35}, {2, 0.9}}},
                                                       {{{2, 0.9}, {2, 0.45}, {1.5, 0.225}, {1.5, 0.15}}},
                                                       {{{1.5, 0.15}, {1.5, 0.075}, {1.425, 0}, {0, 0}}}}};

/// Ring from (xa, 0, za) over (xa, w, za) and (xb, w, zb) to (xb, 0, zb), and mirrored back.
struct TubeRing {
  double xa, za, xb, zb, w;
};
using Tube = std::array<TubeRing, 7>;  // two segments that share the ring in the middle
constexpr Tube handle{{{-1.6, 2.025, -1.5, 2.25, 0.3},
                       {-2.3, 2.025, -2.5, 2.25, 0.3},
                       {-2.7, 2.025, -3, 2.25, 0.3},
                       {-2.7, 1.8, -3, 1.8, 0.3},
                       {-2.7, 1.575, -3, 1.35, 0.3},
                       {-2.5, 1.125, -2.65, 0.9375, 0.3},
                       {-2, 0.9, -1.9, 0.6, 0.3}}};
constexpr Tube spout{{{1.7, 1.425, 1.7, 0.6, 0.66},
                      {2.6, 1.425, 3.1, 0.825, 0.66},
                      {2.3, 2.1, 2.4, 2.025, 0.25},
                      {2.7, 2.4, 3.3, 2.4, 0.25},
                      {2.8, 2.475, 3.525, 2.49375, 0.25},
                      {2.9, 2.475, 3.45, 2.5125, 0.15},
                      {2.8, 2.4, 3.2, 2.4, 0.15}}};

using Weights = std::array<double, 4>;
Weights bernstein(double t) {
  const double s = 1 - t;
  return {s * s * s, 3 * t * s * s, 3 * t * t * s, t * t * t};
}
Weights bernstein_slope(double t) {
  const double s = 1 - t;
  return {-3 * s * s, 3 * s * s - 6 * s * t, 6 * s * t - 3 * t * t, 3 * t * t};
}

/// A row of four control points of a ring, in its quarter or half number `part`.
using Row = std::array<glm::dvec3, 4>;

Row control_row(const Revolved& ring, int part) {
  const int ci[4] = {1, 0, -1, 0};
  const glm::dvec3 e(ci[part % 4], ci[(part + 3) % 4], 0), f(-e.y, e.x, 0), up(0, 0, ring.z);
  return {up + ring.r * e, up + ring.r * (e + ring.k * f), up + ring.r * (ring.k * e + f), up + ring.r * f};
}

Row control_row(const TubeRing& ring, int part) {
  const glm::dvec3 a(ring.xa, 0, ring.za), b(ring.xb, 0, ring.zb), out(0, part == 0 ? ring.w : -ring.w, 0);
  return part == 0 ? Row{a, a + out, b + out, b} : Row{b, b + out, a + out, a};
}

glm::dvec3 combine(const Row& row, const Weights& w) {
  return w[0] * row[0] + w[1] * row[1] + w[2] * row[2] + w[3] * row[3];
}

/// Point of a patch: t along the profile or tube, s along the ring. The normal is dP/dt x dP/ds:
/// outwards for rings that turn counter-clockwise about +z and profiles that run down, and for the tubes.
template <typename Ring>
SurfacePoint patch_point(const Ring* rings, int part, double t, double s) {
  Row along;
  Row ds_along;
  for (int i = 0; i < 4; ++i) {
    const Row row = control_row(rings[i], part);
    along[i] = combine(row, bernstein(s));
    ds_along[i] = combine(row, bernstein_slope(s));
  }
  const glm::dvec3 ds = combine(ds_along, bernstein(t)), dt = combine(along, bernstein_slope(t));
  return {combine(along, bernstein(t)), glm::normalize(glm::cross(dt, ds))};
}

/// Builds one closed part from its first pole to its last, ring by ring.
class Part {
 public:
  Part(Mesh& mesh, int count) : mesh_(mesh), count_(count) {}
  void pole(const SurfacePoint& point) {
    const unsigned p = add_ring(mesh_, 1, [&](int) { return point; });
    if (joined_) join_pole(mesh_, last_, p, count_, true);
    last_ = p;
    after_pole_ = joined_ = true;
  }
  void ring(const std::function<SurfacePoint(int)>& point) {
    const unsigned r = add_ring(mesh_, count_, point);
    if (joined_ && after_pole_) join_pole(mesh_, r, last_, count_, false);
    if (joined_ && !after_pole_) join_rings(mesh_, last_, r, count_);
    last_ = r;
    after_pole_ = false;
    joined_ = true;
  }
  /// The next ring repeats the last one's positions with the normals of the other side.
  void crease() { joined_ = false; }

 private:
  Mesh& mesh_;
  int count_;
  unsigned last_ = 0;
  bool joined_ = false, after_pole_ = false;
};

template <typename Ring>
std::function<SurfacePoint(int)> patch_ring(const Ring* rings, int n, double t) {
  return [=](int i) { return patch_point(rings, i / n, t, static_cast<double>(i % n) / n); };
}

/// Rings at t = first / n ... last / n of one segment of four control rings.
template <typename Ring>
void add_segment(Part& part, const Ring* rings, int n, int first, int last) {
  for (int i = first; i <= last; ++i) part.ring(patch_ring(rings, n, static_cast<double>(i) / n));
}

/// Flat strip between the ring t = 1 of `from` and the ring t = 0 of `to`.
void add_seal(Part& part, const Revolved* from, const Revolved* to, int n) {
  const int rows = 1 + n / 16;
  part.crease();
  for (int k = 0; k <= rows; ++k) {
    const double w = static_cast<double>(k) / rows;
    part.ring([&, w](int i) {
      const glm::dvec3 a = patch_ring(from, n, 1)(i).position, b = patch_ring(to, n, 0)(i).position;
      return SurfacePoint{(1 - w) * a + w * b, {0, 0, 1}};
    });
  }
  part.crease();
}

void add_body(Mesh& mesh, int n) {
  Part part(mesh, 4 * n);
  part.pole({{0, 0, lid[0][0].z}, {0, 0, 1}});
  add_segment(part, lid[0].data(), n, 1, n);
  add_segment(part, lid[1].data(), n, 1, n);
  add_seal(part, lid[1].data(), body[0].data(), n);
  add_segment(part, body[0].data(), n, 0, n);
  add_segment(part, body[1].data(), n, 1, n);
  add_segment(part, body[2].data(), n, 1, n);
  add_segment(part, body[3].data(), n, 1, n - 1);
  part.pole({{0, 0, 0}, {0, 0, -1}});
}

/// Flat cap over an end ring, scaled about its middle in a few rows; from the pole out or back.
void add_cap(Part& part, const TubeRing& end, int n, bool starts) {
  const glm::dvec3 a(end.xa, 0, end.za), b(end.xb, 0, end.zb), middle = 0.5 * (a + b);
  const glm::dvec3 normal = glm::normalize(glm::cross(starts ? a - b : b - a, glm::dvec3(0, 1, 0)));
  const int rows = 1 + n / 4;
  if (starts) part.pole({middle, normal});
  if (!starts) part.crease();
  for (int k = starts ? 1 : 0; k < rows + (starts ? 1 : 0); ++k) {
    const double scale = static_cast<double>(starts ? k : rows - k) / rows;
    part.ring([&, scale](int i) {
      const Row row = control_row(end, i / n);
      const glm::dvec3 edge = combine(row, bernstein(static_cast<double>(i % n) / n));
      return SurfacePoint{scale == 1 ? edge : middle + scale * (edge - middle), normal};
    });
  }
  if (starts) part.crease();
  if (!starts) part.pole({middle, normal});
}

void add_tube(Mesh& mesh, const Tube& tube, int n) {
  Part part(mesh, 2 * n);
  add_cap(part, tube[0], n, true);
  add_segment(part, &tube[0], n, 0, n);
  add_segment(part, &tube[3], n, 1, n);
  add_cap(part, tube[6], n, false);
}

}  // namespace

Mesh make_teapot(double height, int triangles) {
  OPALINE_CHECK(height > 0 && triangles > 0);
  const int n = std::max(2, static_cast<int>(std::lround(std::sqrt(triangles / 64.0))));  // 32 patches of 2 n^2
  Mesh mesh;
  add_body(mesh, n);
  add_tube(mesh, handle, n);
  add_tube(mesh, spout, n);
  const auto y_up = [](glm::vec3 p) { return glm::vec3(p.x, p.z, -p.y); };
  const double scale = height / newell_height;
  for (glm::vec3& p : mesh.positions)
    p = glm::vec3(scale * (glm::dvec3(y_up(p)) - glm::dvec3(0, newell_height / 2, 0)));
  for (glm::vec3& normal : mesh.normals) normal = y_up(normal);
  return mesh;
}

ShapeMaker teapot_shape() {
  return {
      "Newell's teapot, +y up, centred, spout towards +x; handle and spout enter the body, open ends are closed "
      "flat; height; triangles (default 20000, at least 256)",
      [](JsonObject& keys) {
        const double height = keys.number("height", Range::positive());
        return make_teapot(height, keys.integer_or("triangles", 256, max_shape_triangles, 20000));
      }};
}

}  // namespace opaline
