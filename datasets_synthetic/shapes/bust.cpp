#include "datasets_synthetic/shapes/bust_field.h"
#include "datasets_synthetic/shapes/shapes.h"
#include "datasets_synthetic/shapes/zero_set.h"
#include "model/check.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr double ear_cell = 1.2 * bust_ear_thickness;  // the lattice never misses a sheet of 0.71 cell
constexpr double area_mm2 = 2.4e5;                     // of the surface, roughly

/// Lattice fine enough for the ears, and for twice the triangles asked for.
double lattice_cell(int triangles) { return std::min(ear_cell, std::sqrt(13 * area_mm2 / (1.6 * triangles))); }

glm::dvec3 to_caller(const glm::dvec3& p, double height) {
  return height / bust_height * (p - glm::dvec3(0, 0.5 * (bust_crown + bust_base), 0));
}

}  // namespace

Mesh make_bust(double height, int triangles) {
  OPALINE_CHECK(height > 0 && triangles > 0);
  RawMesh raw = extract_zero_set(bust_field, bust_bounds(), lattice_cell(triangles));
  remesh(bust_field, raw, triangles);
  Mesh mesh;
  mesh.triangles = std::move(raw.triangles);
  for (const glm::dvec3& p : raw.positions) {
    mesh.positions.push_back(glm::vec3(to_caller(p, height)));
    mesh.normals.push_back(glm::vec3(glm::normalize(sample_field(bust_field, p).gradient)));
  }
  return mesh;
}

EarPlate bust_ear_plate(double height) {
  const EarProbe probe = bust_ear_probe();
  return {to_caller(probe.centre, height), probe.normal, bust_ear_thickness * height / bust_height};
}

ShapeMaker bust_shape() {
  return {
      "head, neck and shoulders facing +z, +y up, centred, with thin ears; height; triangles (default 60000, at "
      "most 2000000)",
      [](JsonObject& keys) {
        const double height = keys.number("height", Range::positive());
        return make_bust(height, keys.integer_or("triangles", 4000, 2'000'000, 60000));
      }};
}

}  // namespace opaline
