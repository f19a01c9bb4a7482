// Can anything in a scene cast a shadow on it? A single convex object cannot: what faces a light sees it.
#pragma once

#include "render/scene/scene.h"

namespace opaline {

/// Is the mesh a closed, connected surface without a concave edge? Vertices at the same position count as one;
/// an edge that bends inwards by less than 1e-5 of the mesh's extent counts as flat.
bool is_convex(const Mesh& mesh);

/// True when no point that faces a light can be in shadow: one object, and it is convex. (False says nothing.)
bool nothing_in_shadow(const Scene& scene);

}  // namespace opaline
