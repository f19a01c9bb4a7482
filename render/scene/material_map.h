// A coefficient that varies over a surface: an image times a factor, at the surface's texture coordinates.
#pragma once

#include "render/scene/surface_texture.h"

namespace opaline {

struct MaterialMap {
  SurfaceTexture texture;  ///< R, G, B, or one channel for all three; finite and >= 0
  glm::dvec3 scale{1};     ///< coefficient [1/mm] where the image is 1

  glm::dvec3 at(const glm::vec2& uv) const;
  glm::dvec3 smallest() const;  ///< over all texels, per channel [1/mm]
  glm::dvec3 largest() const;
  glm::dvec3 mean() const;
};

}  // namespace opaline
