// Reference points: a subset of the vertices, the triangles they form, and where every vertex lies on these.
#pragma once

#include "render/transfer/transfer_vertices.h"

namespace opaline {

struct ReferenceMesh {
  std::vector<std::uint32_t> points;       ///< vertices
  std::vector<glm::uvec3> triangles;       ///< of points
  std::vector<std::uint32_t> triangle_of;  ///< of each vertex
  std::vector<glm::dvec2> weights;         ///< of its triangle's first and second corner
};

/// By simplification of the mesh (meshoptimizer's quadrics) to about that many points, and the nearest point of the
/// simplified mesh that faces the vertex's way.
ReferenceMesh make_reference_mesh(const TransferVertices& vertices, std::size_t points);

}  // namespace opaline
