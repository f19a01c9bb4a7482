// The scene as its lights see it, for gathering light that enters where the camera doesn't look.
#pragma once

#include "render/visibility/gbuffer.h"

#include <optional>
#include <vector>

namespace opaline {

/// A camera at the light that sees all of the scene: orthographic along a directional light, perspective from a point
/// light or a projector. None for an environment, or for a position so near that the scene fills more than 120 degrees.
std::optional<Camera> light_camera(const Light& light, const Scene& scene);

/// One view, `pixels` square, of each light that can have one; counts those, and the lights that cannot.
std::vector<GBuffer> light_views(const Scene& scene, const RayScene& rays, int pixels, Counters& counters);

}  // namespace opaline
