// Surface samples: each object's triangles, bisected until there are enough of equal size. Every
// cell is a flat triangle, so its area and moments are exact and it can be split further where a
// query comes near; no random placement, no white noise.
#pragma once

#include "render/scene/scene.h"

#include <cstdint>
#include <vector>

namespace opaline {

struct SurfaceCell {
  glm::vec3 a, b, c;       ///< mm, counter-clockwise from outside
  std::uint32_t triangle;  ///< of the object's mesh
};

/// All cells of one object.
using SurfaceCells = std::vector<SurfaceCell>;

/// Splits the longest edge of the largest triangle until `count` cells exist; a mesh with more
/// triangles than that keeps one cell each. Deterministic.
SurfaceCells make_surface_cells(const Mesh& mesh, std::size_t count);

/// Shares `total` cells among the objects in proportion to their areas (at least one each).
std::vector<SurfaceCells> make_surface_cells(const Scene& scene, std::size_t total);

inline glm::vec3 cell_centroid(const SurfaceCell& cell) { return (cell.a + cell.b + cell.c) / 3.0f; }
inline float cell_area(const SurfaceCell& cell) {
  return 0.5f * glm::length(glm::cross(cell.b - cell.a, cell.c - cell.a));
}

/// The four similar quarters of a cell.
void split_in_four(const SurfaceCell& cell, SurfaceCell quarters[4]);

}  // namespace opaline
