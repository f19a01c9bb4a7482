// Single scattering through layers without approximation of the surface: what subsurface texture mapping is judged by.
//
// A place inside lies as deep as the nearest point of the surface is far, and its layers are those of the texel there.
// Light reaches it along the true way: straight, or refracted by the mesh's facets. Both ways are marched so finely
// that halving the steps changes nothing: the change is the error's estimate.
#pragma once

#include "render/path_tracing/interior.h"
#include "render/subsurface/march.h"
#include "render/visibility/closest_triangle.h"

namespace opaline {

struct ExactSettings {
  bool refraction = false;
  double max_relative_error = 1e-3;  ///< of the brightest channel
  int most_steps = 512;
};

struct ExactCounts {
  RayCounts rays;
  SearchCounts search;
  std::uint64_t nearest_points = 0, light_paths = 0, shadowed = 0, estimates = 0, unconverged = 0, lost = 0;
  std::uint64_t steps_negligible = 0;
};

/// One object; all references must outlive it.
class ExactMarch {
 public:
  ExactMarch(const Scene& scene, const RayScene& rays, int object, const ExactSettings& settings);

  struct Estimate {
    glm::dvec3 radiance{0}, error{0};
  };
  Estimate radiance(const VisiblePoint& p, const std::vector<MarchLight>& lights, ExactCounts& counts) const;

 private:
  struct View;
  struct Way;
  /// depth: no less than how far the surface is from the point; then how far it is [mm]
  LayerPlace place_at(const glm::dvec3& point, double& depth, ExactCounts& counts) const;
  LayerPlace place_on_surface(std::uint32_t triangle, const glm::dvec3& point) const;
  Way way_through(const glm::dvec3& from, const LayerPlace& start, double depth, const glm::dvec3& direction,
                  double length, double step, const LayerPlace* end, ExactCounts& counts) const;
  glm::dvec3 scattered(const View& view, const std::vector<MarchLight>& lights, int steps, ExactCounts& counts) const;
  glm::dvec3 arriving(const glm::dvec3& m, int layer, const View& view, const std::vector<MarchLight>& lights,
                      double step, ExactCounts& counts) const;
  template <typename Visit>
  void for_each_light(const glm::dvec3& m, const MarchLight& light, ExactCounts& counts, Visit&& visit) const;

  const Mesh& mesh_;
  ExactSettings settings_;
  double eta_;
  const LayeredMedium& textures_;
  MediumLayers stack_;
  ClosestTriangle surface_;
  Interior interior_;
};

}  // namespace opaline
