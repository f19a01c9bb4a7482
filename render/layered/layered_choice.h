// Layers, threshold and resolution: as given, or picked from a wanted error.
#pragma once

#include "render/layered/kernel_spectrum.h"
#include "render/layered/layered_settings.h"

#include <string>
#include <vector>

namespace opaline {

/// What one object is rendered with.
struct LayeredChoice {
  int layers = 1;
  double threshold = 0;
  std::vector<double> nodes_per_pixel;  ///< per profile: powers of two from 1/64 to 4
  std::string note;                     ///< "8 layers, threshold 0.001, resolution 50 %"
};

/// The length over which a profile spreads light [mm]: 1/k at K(k; 0) = K(0; 0)/e.
double spread_length(const PlaneSpectrum& spectrum);

/// depth: between the nearest and the farthest surface; pixel: of the film [mm]. The rules were fitted to measured
/// errors; see the technique's page.
LayeredChoice choose(const LayeredSettings& settings, const std::vector<PlaneSpectrum>& spectra, double depth,
                     double pixel);

}  // namespace opaline
