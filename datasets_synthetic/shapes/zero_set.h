// Triangle meshes of the zero set of a field.
#pragma once

#include "render/scene/mesh.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace opaline {

/// A distance-like field: negative inside, continuously differentiable, |gradient| near 1 close to
/// its zero set and at most about 1.5 anywhere.
using Field = std::function<double(const glm::dvec3&)>;

struct Box {
  glm::dvec3 lo, hi;
};

/// Value and gradient, from four samples (error O(step^2)).
struct FieldSample {
  double value;
  glm::dvec3 gradient;
};
FieldSample sample_field(const Field& field, const glm::dvec3& p);

struct RawMesh {
  std::vector<glm::dvec3> positions;
  std::vector<glm::uvec3> triangles;  ///< counter-clockwise seen from outside
};

/// Marching tetrahedra on a body-centred cubic lattice with cubes of edge `cell`. Always a closed
/// manifold if the zero set lies inside the box; sheets thicker than 0.71 cell are never lost.
/// About 13 area / cell^2 triangles, of uneven quality.
RawMesh extract_zero_set(const Field& field, const Box& box, double cell);

/// Collapses the cheapest edges until `triangles` are left (edges in flat places are cheaper), then
/// evens the triangles out by flips and by sliding vertices along the zero set. Keeps the topology:
/// an edge is only collapsed or flipped where the result stays a manifold and no triangle turns
/// over. Vertices end on the zero set.
void remesh(const Field& field, RawMesh& mesh, int triangles);

}  // namespace opaline
