// The lights of a scene as a transfer table knows them: from a direction, at a distance.
//
// The table's nodes are a direction set times an axis of inverse distance u = R / d, d from the middle of the object,
// R the radius of a ball around it: level 0 is u = 0, directional light; the last level is u = nearest_u. A node's
// light has irradiance 1 on a plane that faces it in the middle: a point light of intensity d^2. In u the transfer is
// smooth up to infinite distance, so few levels do; between them it is interpolated linearly.
#pragma once

#include "render/scene/scene.h"
#include "render/transfer/direction_set.h"

#include <optional>
#include <vector>

namespace opaline {

/// Light from one direction.
struct TransferLight {
  glm::dvec3 direction;  ///< from the middle of the object towards the light
  double u = 0;          ///< R / distance, 0 for directional light
  Rgb irradiance{0};     ///< in the middle, on a plane facing the light
};

/// A weight of each colour for a row of a table.
struct KeyWeight {
  std::uint32_t key;
  Rgb weight;
};

/// Nodes of one object's table; node = level * directions + direction.
struct TransferNodes {
  static constexpr double nearest_u = 0.9;

  glm::dvec3 middle{0};
  double radius = 1;  ///< R [mm]
  DirectionSet directions;
  int levels = 1;  ///< of distance, level 0 included

  std::uint32_t count() const { return static_cast<std::uint32_t>(levels) * per_level(); }
  std::uint32_t per_level() const { return static_cast<std::uint32_t>(directions.size()); }
  const glm::dvec3& direction(std::uint32_t node) const { return directions[node % per_level()]; }
  double u(std::uint32_t node) const { return level_step() * (node / per_level()); }
  double level_step() const { return levels > 1 ? nearest_u / (levels - 1) : 1; }

  /// Lower level, and the weight of the one above it.
  std::pair<int, double> level_of(double u) const;
};

/// The ball around a mesh's bounding box.
TransferNodes transfer_nodes(const Mesh& mesh, int directions, int levels,
                             DirectionInterpolation interpolation = DirectionInterpolation::four);

/// Every light as single directions: a disk by `area_samples`, an environment by parts of at most 2.8 degrees.
std::vector<TransferLight> transfer_lights(const Scene& scene, const TransferNodes& nodes, int area_samples);

/// Weights of the nodes whose values make that of the lights, by interpolation; ascending keys.
std::vector<KeyWeight> node_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes);

/// The same for tables of vectors: key = 3 * node + axis.
std::vector<KeyWeight> vector_weights(const std::vector<TransferLight>& lights, const TransferNodes& nodes);

/// Why the lights of a scene have no place in a table; empty if they have.
std::string transfer_lights_not_applicable(const Scene& scene);

}  // namespace opaline
