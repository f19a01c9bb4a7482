// Surfaces made of closed rings of vertices, joined by strips: the torus and the teapot.
#pragma once

#include "render/scene/mesh.h"

#include <functional>

namespace opaline {

struct SurfacePoint {
  glm::dvec3 position, normal;
};

/// Appends `count` vertices, ring point i at point(i); returns the first one's index.
unsigned add_ring(Mesh& mesh, int count, const std::function<SurfacePoint(int)>& point);

/// Joins two rings of `count` vertices with 2 * count triangles, each cell cut along its shorter
/// diagonal. (from ring a to ring b) x (next along the ring) points outside.
void join_rings(Mesh& mesh, unsigned a, unsigned b, int count);

/// Closes a ring with a fan to one vertex, on the side where ring b would be (`pole_is_b`) or a.
void join_pole(Mesh& mesh, unsigned ring, unsigned pole, int count, bool pole_is_b);

}  // namespace opaline
