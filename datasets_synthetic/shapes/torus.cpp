#include "datasets_synthetic/shapes/rings.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "model/check.h"
#include "model/conventions.h"

#include <algorithm>
#include <cmath>

namespace opaline {

Mesh make_torus(double major_radius, double minor_radius, int triangles) {
  OPALINE_CHECK(minor_radius > 0 && major_radius > minor_radius && triangles > 0);
  const double cells = triangles / 2.0, ratio = major_radius / minor_radius;
  const int around = std::max(3, static_cast<int>(std::lround(std::sqrt(cells / ratio))));
  const int along = std::max(3, static_cast<int>(std::lround(cells / around)));
  Mesh mesh;
  for (int i = 0; i < along; ++i) {
    const double u = 2 * pi * i / along;
    const glm::dvec3 out(std::cos(u), std::sin(u), 0);
    add_ring(mesh, around, [&](int j) {
      const double v = 2 * pi * j / around;
      const glm::dvec3 normal = std::cos(v) * out + glm::dvec3(0, 0, std::sin(v));
      return SurfacePoint{major_radius * out + minor_radius * normal, normal};
    });
  }
  for (int i = 0; i < along; ++i) join_rings(mesh, i * around, (i + 1) % along * around, around);
  return mesh;
}

ShapeMaker torus_shape() {
  return {"torus about z, centred at the origin; major_radius > minor_radius; triangles (default 20000, at least 18)",
          [](JsonObject& keys) {
            const double major = keys.number("major_radius", Range::positive());
            const double minor = keys.number("minor_radius", Range::positive());
            if (!(minor < major)) keys.fail("minor_radius", "must be smaller than major_radius");
            return make_torus(major, minor, keys.integer_or("triangles", 18, max_shape_triangles, 20000));
          }};
}

}  // namespace opaline
