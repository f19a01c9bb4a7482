// From loose triangles to an indexed mesh: equal vertices joined, missing normals smoothed.
#pragma once

#include "render/scene/mesh.h"

#include <vector>

namespace opaline {

/// Triangles that share nothing: three corners each, in order.
struct TriangleSoup {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  ///< per corner, any length; zero: none given
  std::vector<glm::vec2> uvs;      ///< per corner; empty: none
};

/// Joins corners that agree bit for bit in position, normal and uv (uv seams and creases stay
/// apart). A corner without a normal gets the angle-weighted mean over the triangles around its
/// vertex that it reaches across edges with an angle of at most `crease_deg` between face normals.
/// Seams of uv don't stop the smoothing; triangles of zero area take no part in it.
Mesh weld_soup(const TriangleSoup& soup, double crease_deg);

}  // namespace opaline
