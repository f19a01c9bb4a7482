// Depth textures from meshes: how deep below a surface, along its normal, other surfaces lie.
#pragma once

#include "render/counters.h"
#include "render/image.h"
#include "render/scene/mesh.h"

#include <span>
#include <vector>

namespace opaline {

/// One texture (R, G, B, A in mm) for every four layers. A texel is the place of the surface with its texture
/// coordinates; a ray goes in there against the normal, and where it meets the mesh of layer k, that layer ends. Depths
/// never fall from one layer to the next, none is more than `largest_depth`, and a ray that meets nothing has that.
///
/// The surface has texture coordinates. Texels that no triangle covers take the mean of their neighbours, again and
/// again until all have one. Where several triangles cover a texel, as the two sides of a planar projection do, the
/// first counts. Counts: done rays; skipped texels_off_surface, texels_covered_again.
std::vector<Image> make_depth_textures(const Mesh& surface, std::span<const Mesh> layers, int width, int height,
                                       double largest_depth, Counters& counters);

}  // namespace opaline
