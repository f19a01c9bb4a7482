// A fish: closed cross-sections along its axis, with fins that are thin parts of them.
#include "datasets_synthetic/shapes/rings.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "model/check.h"
#include "model/conventions.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

double bell(double t, double centre, double width) { return std::exp(-std::pow((t - centre) / width, 2)); }

/// The surface of a fish of length 1 at t along its axis (0 the end of the tail, 1 the nose) and an angle round it (0
/// the left side, pi / 2 the back).
glm::dvec3 fish_point(double t, double angle) {
  const double body = std::clamp((t - 0.1) / 0.9, 0.0, 1.0), bulk = 4 * body * (1 - body);
  // Both ends are round: the cross-section closes like a circle's.
  const double near_end = 0.05, a = std::max(0.0, 1 - t / near_end), b = std::max(0.0, 1 - (1 - t) / near_end);
  const double close = std::sqrt(std::max(0.0, 1 - a * a)) * std::sqrt(std::max(0.0, 1 - b * b));
  const double tall = close * (0.03 + 0.12 * std::pow(bulk, 0.8) + 0.14 * bell(t, 0.02, 0.09));
  const double wide = close * (0.008 + 0.065 * std::pow(bulk, 0.7));
  const double sine = std::sin(angle), cosine = std::cos(angle);
  const double fin = sine > 0 ? 0.075 * bell(t, 0.56, 0.12) : -0.055 * bell(t, 0.33, 0.07);
  return {t - 0.5, tall * sine + close * fin * std::pow(std::abs(sine), 24), wide * cosine};
}

SurfacePoint with_normal(double t, double angle) {
  constexpr double h = 1e-5;
  const double lo = std::max(t - h, 0.0), hi = std::min(t + h, 1.0);
  const glm::dvec3 along = fish_point(hi, angle) - fish_point(lo, angle),
                   round = fish_point(t, angle + h) - fish_point(t, angle - h);
  return {fish_point(t, angle), glm::normalize(glm::cross(along, round))};
}

}  // namespace

Mesh make_fish(double length, int triangles) {
  OPALINE_CHECK(length > 0 && triangles > 0);
  const int around = std::max(8, 4 * static_cast<int>(std::lround(std::sqrt(triangles / 2.0 / 1.6) / 4)));
  const int along = std::max(8, static_cast<int>(std::lround(triangles / 2.0 / around)));
  Mesh mesh;
  const auto pole = [&](double t, double side) {
    mesh.positions.emplace_back(fish_point(t, 0));
    mesh.normals.emplace_back(side, 0, 0);
  };
  pole(0, -1);
  for (int i = 1; i < along; ++i) {
    // Closer where the cross-sections change: at both ends.
    const double t = 0.5 - 0.5 * std::cos(pi * i / along);
    add_ring(mesh, around, [&](int j) {
      // And at the ridges of back and belly, where the fins are.
      const double turn = 2 * pi * j / around;
      return with_normal(t, turn + 0.35 * std::sin(2 * turn));
    });
  }
  pole(1, 1);
  join_pole(mesh, 1, 0, around, false);
  for (int i = 1; i + 1 < along; ++i) join_rings(mesh, 1 + (i - 1) * around, 1 + i * around, around);
  join_pole(mesh, 1 + (along - 2) * around, static_cast<unsigned>(mesh.positions.size()) - 1, around, true);
  for (glm::vec3& p : mesh.positions) p *= static_cast<float>(length);
  return mesh;
}

ShapeMaker fish_shape() {
  return {"fish along x, nose towards +x, back towards +y, centred; length; triangles (default 4000, at least 112)",
          [](JsonObject& keys) {
            const double length = keys.number("length", Range::positive());
            return make_fish(length, keys.integer_or("triangles", 112, max_shape_triangles, 4000));
          }};
}

}  // namespace opaline
