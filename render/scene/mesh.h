// Triangle meshes: the only surface representation. Units: mm once in a Scene; a mesh file's own
// units before (see mm_per_unit).
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <string>
#include <vector>

namespace opaline {

struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;     ///< per vertex, unit, outward; empty: use face normals
  std::vector<glm::vec2> uvs;         ///< per vertex; empty: none
  std::vector<glm::uvec3> triangles;  ///< counter-clockwise seen from outside
};

/// What to do with triangles of zero area (area below 1e-14 of the squared bounding diagonal).
enum class ZeroAreaTriangles { reject, drop };

/// Loads OBJ, PLY, glTF (.gltf, .glb) or STL. All meshes of the file are merged, node transforms
/// applied, polygons triangulated in file order, points and lines left out, equal vertices joined.
/// Normals: the file's own if it has them, else smoothed over edges flatter than 60 degrees.
/// Throws InputError for a file that is missing, unreadable, cut short or empty, that has vertices
/// that are not finite, or faces that name vertices it doesn't have. Call validate_mesh next.
Mesh load_mesh(const std::string& path);

/// Throws InputError(file, place, ...) for an empty mesh, non-finite vertices, indices out of range
/// or, with `reject`, zero-area triangles (naming the count, the first one and the way out). With
/// `drop` removes those triangles and the vertices that only they used; returns how many triangles.
std::size_t validate_mesh(Mesh& mesh, ZeroAreaTriangles policy, const std::string& file, const std::string& place);

/// Sum of the triangle areas [squared units of the positions].
double surface_area(const Mesh& mesh);

}  // namespace opaline
