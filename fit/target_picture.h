// A target as people have it, made into linear light with a mask and a noise: file format, exposure, saturation,
// highlights, repeated captures.
#pragma once

#include "fit/noise_model.h"
#include "render/scene/scene.h"

#include <optional>
#include <string>
#include <vector>

namespace opaline {

struct TargetOptions {
  std::string mask;      ///< image; first channel > 0: use. Empty: all
  std::string transfer;  ///< transfer_curve.h; empty: linear, for formats that are linear by convention
  double exposure = 1;   ///< the file's linear values are this times the scene's radiance
  /// Stored values at or above are saturated and their pixels are left out. Unset: 0.999 for formats that are not
  /// linear by convention, none for those that are.
  std::optional<double> saturation;
  double exclude_specular_deg = 0;  ///< leave out pixels whose mirror direction is this near a light; 0: none
  std::string repeat;               ///< a second capture of the same: averaged, and the noise from the difference
  std::string noise = "uniform";    ///< uniform, shared, flat, layer, or READ[,SHOT]
};

struct TargetPicture {
  Image linear;               ///< R, G, B or one channel, in the scene's units
  std::vector<float> usable;  ///< per pixel, > 0: takes part
  NoiseModel noise;
  std::size_t saturated = 0, near_highlights = 0, masked = 0;  ///< pixels left out, counted in this order: mask first
};

/// Throws InputError: file, place, valid choices.
TargetPicture read_target(const std::string& path, const Scene& scene, const TargetOptions& options);

/// One value per film pixel: 0 where the mirror direction of the view lies within `degrees` of a directional, point or
/// projector light (of a disk's edge), 1 elsewhere. Environments have no one direction and are left alone.
std::vector<float> away_from_highlights(const Scene& scene, double degrees);

}  // namespace opaline
