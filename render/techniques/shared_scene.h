// What all techniques share: made once per scene, never again.
#pragma once

#include "render/irradiance/irradiance.h"
#include "render/visibility/gbuffer.h"

#include <memory>

namespace opaline {

struct SharedSettings {
  std::size_t samples = 100000;  ///< surface cells over all objects
  IrradianceSettings irradiance;
};

/// Seconds spent on the shared parts.
struct SharedSeconds {
  double gbuffer = 0, irradiance = 0;
};

/// What of a SharedScene can be kept in a file: all but the ray-tracing structure.
struct SharedParts {
  GBuffer view;
  std::vector<SurfaceCells> cells;          ///< per object; empty without irradiance
  std::vector<IrradianceField> irradiance;  ///< per object, for its material's eta
  Counters counters;
  SharedSeconds seconds;
};

/// The scene must outlive it.
struct SharedScene : SharedParts {
  const Scene& scene;
  SharedSettings settings;
  RayScene rays;

  SharedScene(const Scene& scene, const SharedSettings& settings, bool with_irradiance = true);
  /// With parts that were made of the same scene with the same settings.
  SharedScene(const Scene& scene, const SharedSettings& settings, SharedParts parts);

  /// Cells and irradiance anew, after the scene's lights were edited.
  void make_irradiance();
};

/// Positions of the visible points of one object, and their places in the view.
struct ObjectPoints {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
};
ObjectPoints points_of_object(const GBuffer& view, int object);

}  // namespace opaline
