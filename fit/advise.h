// Which further picture would tighten a fit most, by Fisher information on the scene at hand.
#pragma once

#include "fit/uncertainty.h"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace opaline {

struct Advice {
  std::string what;                          ///< the additional picture, in words
  nlohmann::json light, camera;              ///< to put into a scene file; null where unchanged
  std::array<double, parameter_count> sd{};  ///< of the solver's parameters, with that picture added
  double factor = 1;                         ///< geometric mean over the free parameters of sd now / sd then
};

struct AdviseSettings {
  int pixels = 48;              ///< height of the trial pictures; information is scaled up to the scene's film
  std::size_t samples = 12000;  ///< surface cells of the trials
};

/// Trial pictures: directional light from sides and from behind, a narrow beam straight and oblique onto what the
/// camera sees at its centre, and views from beside. Each is given noise of `relative_noise` times its brightest value
/// (exposures make up for dim pictures, down to a hundredth of the brightest trial) and the scene's number of pixels.
/// Best first.
std::vector<Advice> advise(const Scene& scene, int material_index, const ProfileInfo& profile, const Solution& solution,
                           const Uncertainty& now, const FreeParameters& free, double relative_noise,
                           const AdviseSettings& settings = {});

}  // namespace opaline
