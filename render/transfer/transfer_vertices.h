// The points at which a transfer table is kept: a mesh's vertices, or those of its triangles cut into k^2 equal parts.
// Between them pictures are interpolated over the (part of a) triangle.
#pragma once

#include "render/scene/mesh.h"

#include <array>
#include <cstdint>
#include <vector>

namespace opaline {

class TransferVertices {
 public:
  static constexpr std::uint32_t none = ~0u;

  /// parts: k >= 1. The vertices lie along a Morton curve.
  TransferVertices(const Mesh& mesh, int parts);

  /// Leaves only the parts of triangles that hold one of these points; returns the old numbers of the vertices left.
  std::vector<std::uint32_t> keep_only(const Mesh& mesh,
                                       const std::vector<std::pair<std::uint32_t, glm::vec3>>& points);

  std::size_t size() const { return positions.size(); }

  /// Three vertices and their weights at a point of a triangle of the mesh; corner[0] == none: not kept.
  struct Place {
    glm::uvec3 corner;
    glm::vec3 weight;
  };
  Place at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position) const;

  std::vector<glm::vec3> positions, normals;  ///< mm; unit, outward
  std::vector<glm::uvec3> triangles;          ///< k^2 in a row for each of the mesh; none: not kept

 private:
  std::size_t part_at(const Mesh& mesh, std::uint32_t triangle, const glm::vec3& position, glm::vec3& weight) const;
  void renumber(const std::vector<std::uint32_t>& order);
  int parts_;
};

/// A third of the area of the triangles at each vertex [mm^2]: they add up to the area of the surface.
std::vector<double> vertex_areas(const std::vector<glm::vec3>& positions, const std::vector<glm::uvec3>& triangles);

}  // namespace opaline
