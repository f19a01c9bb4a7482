// A material made of layers whose thickness varies over the surface (Francois et al. 2006): for techniques of single
// scattering in layers.
//
// Textures hold, at the surface's texture coordinates, how deep below the surface along its normal each layer ends.
// The last layer scatters down to where it ends; what is below that absorbs as the last layer does and doesn't scatter.
#pragma once

#include "model/single_scattering/half_space.h"
#include "render/scene/surface_texture.h"

#include <vector>

namespace opaline {

struct SubsurfaceLayer {
  glm::dvec3 sigma_s{1}, sigma_t{1};  ///< [1/mm], 0 <= sigma_s <= sigma_t
  double g = 0;                       ///< of the phase function, in (-1, 1)
  Phase phase = Phase::schlick;
};

struct LayeredMedium {
  static constexpr int most_layers = 16;

  std::vector<SubsurfaceLayer> layers;  ///< from the surface inwards, 1 .. most_layers
  std::vector<SurfaceTexture> depths;   ///< layer k ends at channel k % 4 of texture k / 4, times depth_scale
  double depth_scale = 1;               ///< [mm] where a texture is 1

  int count() const { return static_cast<int>(layers.size()); }
  /// Depths at which the layers end [mm]: none less than the one before it, however the textures are.
  void boundaries(const glm::vec2& uv, float* out) const;
  /// The largest depth at which the last layer ends, and the largest thickness of each layer, over all texels [mm].
  double largest_depth() const;
  std::vector<double> largest_thickness() const;
};

}  // namespace opaline
