#include "render/transfer/reference_mesh.h"

#include "model/check.h"
#include "render/visibility/closest_triangle.h"

#include <meshoptimizer.h>
#include <tbb/parallel_for.h>

#include <map>

namespace opaline {
namespace {

std::vector<unsigned> kept_corners(const TransferVertices& vertices) {
  std::vector<unsigned> corners;
  corners.reserve(3 * vertices.triangles.size());
  for (const glm::uvec3& t : vertices.triangles)
    if (t.x != TransferVertices::none) corners.insert(corners.end(), {t.x, t.y, t.z});
  return corners;
}

}  // namespace

ReferenceMesh make_reference_mesh(const TransferVertices& vertices, std::size_t points) {
  const std::vector<unsigned> all = kept_corners(vertices);
  OPALINE_CHECK(!all.empty());
  std::vector<unsigned> few(all.size());
  const std::size_t target = std::min(6 * std::max<std::size_t>(points, 4), all.size());  // two triangles a point
  constexpr float any_error = 1;
  few.resize(meshopt_simplify(few.data(), all.data(), all.size(), &vertices.positions[0].x, vertices.size(),
                              sizeof(glm::vec3), target, any_error, 0, nullptr));
  if (few.empty()) few = all;
  ReferenceMesh mesh;
  std::map<std::uint32_t, std::uint32_t> number;
  for (const unsigned v : few)
    if (number.try_emplace(v, static_cast<std::uint32_t>(mesh.points.size())).second) mesh.points.push_back(v);
  for (std::size_t k = 0; k < few.size(); k += 3)
    mesh.triangles.push_back({number[few[k]], number[few[k + 1]], number[few[k + 2]]});
  std::vector<glm::vec3> positions;
  for (const std::uint32_t v : mesh.points) positions.push_back(vertices.positions[v]);
  const ClosestTriangle search(positions, mesh.triangles);
  mesh.triangle_of.resize(vertices.size());
  mesh.weights.resize(vertices.size());
  tbb::parallel_for(std::size_t{0}, vertices.size(), [&](std::size_t v) {
    const TrianglePlace place = search.find(vertices.positions[v], vertices.normals[v]);
    mesh.triangle_of[v] = place.triangle;
    mesh.weights[v] = {place.weights.x, place.weights.y};
  });
  return mesh;
}

}  // namespace opaline
