// One object as its own light sees it from inside: where a ray meets the boundary, and whether a refracted ray to a
// light is free.
#pragma once

#include "render/path_tracing/facet_tree.h"
#include "render/visibility/ray_scene.h"

#include <optional>

namespace opaline {

struct RayCounts {
  std::uint64_t boundary = 0, shadow = 0;
};

struct BoundaryHit {
  std::uint32_t facet;
  double distance;
};

class Interior {
 public:
  /// Scene and rays must outlive it. The object's mesh must be closed.
  Interior(const Scene& scene, const RayScene& rays, int object);

  const Material& material() const { return material_; }
  double eta() const { return material_.eta; }
  /// 4 volume / area: the mean length of a straight way through, for isotropic light.
  double mean_chord() const { return mean_chord_; }
  const FacetTree& tree() const { return tree_; }
  const Facet& facet(std::uint32_t i) const { return tree_.facets()[i]; }

  /// The first facet met from inside. Facets met from outside don't count: they are what the ray starts from, within
  /// rounding. None: the ray slipped out at an edge by rounding.
  std::optional<BoundaryHit> boundary(const glm::dvec3& from, const glm::dvec3& direction, RayCounts& counts) const;

  /// Is nothing between a point inside and `length` along the direction?
  bool free_inside(const glm::dvec3& from, const glm::dvec3& direction, double length, RayCounts& counts) const;
  /// Is nothing between a point of the surface with that normal and what is `length` away outside?
  bool free_outside(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& direction, double length,
                    RayCounts& counts) const;

 private:
  const RayScene& rays_;
  int object_;
  const Material& material_;
  double mean_chord_;
  FacetTree tree_;
};

/// Empty if every edge of the mesh is shared by facets of both directions in equal number (positions count, not
/// indices) and the volume is positive; else what is wrong.
std::string closed_mesh_fault(const Mesh& mesh);

}  // namespace opaline
