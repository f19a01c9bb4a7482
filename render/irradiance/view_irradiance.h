// Irradiance that has entered at every visible point of a view: what an image-space technique gathers from.
#pragma once

#include "render/irradiance/irradiance.h"
#include "render/visibility/gbuffer.h"

namespace opaline {

/// values[point * channels + c] for the points of the view. With channels == 1 the RGB irradiance is
/// colour * value.
struct ViewIrradiance {
  int channels = 1;
  Rgb colour{1};
  std::vector<float> values;
};

/// One shadow ray for each light (area_samples for an extended one) at each point that faces it; none where
/// `unshadowed` says that nothing casts a shadow. Each object's light enters through its material's eta.
ViewIrradiance view_irradiance(const Scene& scene, const RayScene& rays, const GBuffer& view,
                               const IrradianceSettings& settings, bool unshadowed, Counters& counters);

}  // namespace opaline
