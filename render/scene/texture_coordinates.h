// Texture coordinates of a mesh: made where it has none, and read at a point.
#pragma once

#include "render/scene/mesh.h"

namespace opaline {

/// How coordinates are made from positions. The bounding box of the mesh decides the scale.
///   planar       u over x and v over y: what one sees looking along -z. The far side shows the mirrored image.
///   cylindrical  u round the y axis through the box's middle (0 at -z, 0.5 at +z, growing towards +x there), v over y
///   spherical    u as cylindrical, v the angle from -y (0) to +y (1) about the box's middle
enum class UvProjection { planar, cylindrical, spherical };

/// Gives every vertex a coordinate, in place of what it had. Triangles across the seam at -z, and those at a pole, get
/// vertices of their own, so that u runs on across them (it may leave [0, 1]: let textures repeat).
void make_texture_coordinates(Mesh& mesh, UvProjection projection);

/// At a position in the plane of a triangle; the mesh has uvs.
glm::vec2 uv_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position);

}  // namespace opaline
