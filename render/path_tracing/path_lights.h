// The lights of a scene as a path inside a medium meets them.
#pragma once

#include "render/irradiance/light_sampler.h"
#include "render/path_tracing/facet.h"
#include "render/path_tracing/random.h"

#include <vector>

namespace opaline {

/// A light reduced to one direction or position, with what it sends there.
struct Lamp {
  PointOrDirection where;
  Rgb irradiance{0};  ///< of a far light, on a plane facing it, divided by the density of the direction
};

class PathLights {
 public:
  explicit PathLights(const Scene& scene);

  std::size_t size() const { return scene_.lights.size(); }
  /// An environment fills all directions: a path finds it by leaving. Other lights can't be hit, or hardly.
  bool is_environment(std::size_t light) const;

  /// A direction of an extended light by chance, else the light as it is.
  Lamp lamp(std::size_t light, RandomStream& random) const;
  /// What may be lit at all: the axis of an extended light, with the spread of its directions as second.
  std::pair<PointOrDirection, double> reach(std::size_t light) const;

  /// Irradiance (far) or intensity (near) of the lamp of that light towards a point of the surface.
  Rgb power(std::size_t light, const Lamp& lamp, const glm::dvec3& point) const;

  /// Radiance that comes from direction w: of environments if asked for, of disks if asked for.
  Rgb radiance(const glm::dvec3& w, bool environments, bool disks) const;

 private:
  const Scene& scene_;
  LightSampler sampler_;
};

}  // namespace opaline
