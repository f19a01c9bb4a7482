// What a transfer table sums over: elements of the surface, each lit at a few points, and the light of the table's
// nodes on them.
//
//   cells      the mesh's triangles, cut until there are enough; near a vertex the gather cuts them further, so the
//              vertex's own surroundings are integrated. The default.
//   discs      as published: one element for each vertex, with a third of the area of its triangles. Its own vertex
//              sees it as a disc of that area, integrated in closed form: int R_d dA = cumulative(sqrt(A / pi)). (The
//              paper leaves this term out, the largest of all on a coarse mesh.)
#pragma once

#include "render/counters.h"
#include "render/irradiance/surface_cells.h"
#include "render/transfer/transfer_lights.h"
#include "render/transfer/transfer_vertices.h"
#include "render/visibility/ray_scene.h"

#include <span>
#include <vector>

namespace opaline {

/// Columns a table is made of at a time.
inline constexpr std::size_t transfer_columns = 32;

struct TransferElements {
  SurfaceCells cells;                ///< of the elements' areas; of a disc an equilateral triangle in its plane
  std::vector<SurfacePoint> points;  ///< where each is lit: of a cell the middles of its quarters, the central one last
  bool discs = false;
  std::size_t points_each() const { return discs ? 1 : 4; }
};

TransferElements cell_elements(const Mesh& mesh, std::size_t count);
TransferElements disc_elements(const TransferVertices& vertices);

/// Which light a column holds: of a node, or of one component of its vector (key = 3 node + axis).
struct TransferColumns {
  const TransferNodes& nodes;
  bool vectors = false;
};

/// out[element * transfer_columns + k]: irradiance that has entered the element under the node's light,
/// V F_t(eta, cos) cos, of a vector V F_t(eta, cos) n, meant over its points. Shadows of the whole scene, by one ray to
/// an element all of whose points face the light, else by one for each that does; none are looked for where
/// `unshadowed` says that there are none.
void light_elements(const TransferElements& elements, const TransferColumns& columns,
                    std::span<const std::uint32_t> keys, double eta, const RayScene& rays, bool unshadowed,
                    std::vector<float>& out, Counters& counters);

}  // namespace opaline
