// Which technique and settings to render a scene with, out of what was measured on other scenes.
//
// A way of rendering (technique, backend, settings) is judged by the worst relative_rmse it had on any measured scene
// and material, and by the largest time it is expected to take: irradiance and prepare as measured, the frame in
// proportion to the pixels of the film. Only ways that were done on every measured scene they can render are
// considered: a record that is not applicable excuses them, as scenes of layered materials do all techniques of
// profiles.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

struct Way {
  std::string technique, backend;
  std::map<std::string, std::string> settings;
  std::uint64_t samples = 0;    ///< surface cells that it was measured with
  double worst_error = 0;       ///< relative_rmse
  double expected_seconds = 0;  ///< of a first picture with the asked number of pixels
  std::string worst_scene;      ///< "scene, material" of worst_error
  std::size_t scenes = 0;       ///< measured pairs of scene and material
};

/// All ways that the records know, for a film of that many pixels.
std::vector<Way> ways(const std::vector<Record>& records, double pixels);

/// Those with worst_error <= max_error, fastest first.
std::vector<Way> fastest_within_error(std::vector<Way> ways, double max_error);

/// Those with expected_seconds <= max_seconds, most accurate first.
std::vector<Way> most_accurate_within(std::vector<Way> ways, double max_seconds);

}  // namespace opaline
