// From the world to the clip coordinates of a view.
#pragma once

#include "render/image_space/projection.h"

namespace opaline::gl {

/// Of a film of width x height pixels, its top at y = +1, its depth just around the scene's objects.
glm::mat4 clip_matrix(const Scene& scene, const Projection& view, int width, int height);

}  // namespace opaline::gl
