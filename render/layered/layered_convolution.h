// Layered convolution (Munoz et al. 2011): what its CPU and GPU techniques share. See
// render/techniques/layered_convolution.md for the derivation, what is done differently, and the limits.
#pragma once

#include "render/irradiance/profile_gather.h"
#include "render/layered/layered_pass.h"
#include "render/techniques/technique.h"

#include <memory>

namespace opaline {

/// One object's profiles and their spectra, one per distinct channel.
struct LayeredObject {
  std::unique_ptr<ChannelProfiles> profiles;
  std::vector<PlaneSpectrum> spectra;
  std::array<std::size_t, 3> spectrum_of{};  ///< of each colour channel
};
std::vector<LayeredObject> layered_objects(const Scene& scene, const LayeredSettings& settings);

/// A view of all objects; `backend` carries out the passes.
Frame render_layered(const SharedScene& shared, const std::vector<LayeredObject>& objects,
                     const LayeredSettings& settings, const GBuffer& view, LayeredBackend& backend);

/// The technique's GPU twin: transforms and products in compute shaders.
std::unique_ptr<PreparedTechnique> prepare_layered_convolution_gl(const SharedScene& shared, const Settings& settings,
                                                                  const gl::Context& context);

}  // namespace opaline
