// Irradiance at the points of a view by rasterised shadow maps: what view_irradiance traces rays for.
//
// One depth image per light, made once; then one fragment pass per light over the view's points. Lights without
// extent only: directional (angular radius 0), point and projector. A point counts as lit where it is no deeper than
// the map, moved along its face normal by two of the map's texels: shadows are right to about that width.
#pragma once

#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/irradiance/view_irradiance.h"

#include <map>
#include <memory>

namespace opaline::gl {

class ShadowIrradiance {
 public:
  /// map_pixels: side of each shadow map. None is made where nothing can be in shadow. Throws InputError, naming the
  /// light, for one that has extent or is too near the scene for a view of it. The scene must outlive it.
  ShadowIrradiance(const Context& context, const Scene& scene, int map_pixels);

  ViewIrradiance at(const GBuffer& view, Counters& counters) const;

 private:
  struct LightMap {
    std::unique_ptr<Texture2D> depth;  ///< null: nothing is in shadow
    glm::mat4 to_clip{1};
    float scale = 1;                   ///< pixels (perspective) or pixels/mm
    std::unique_ptr<Texture2D> image;  ///< of a projector, or one black texel
  };
  struct PointTextures;
  void draw_depth(const Scene& scene, LightMap& map) const;
  void set_light(const Light& light, const LightMap& map) const;

  const Context& context_;
  const Scene& scene_;
  Program depth_program_, light_program_;
  VertexArray film_;
  std::vector<LightMap> maps_;                            ///< per light
  std::map<double, std::unique_ptr<Texture1D>> fresnel_;  ///< F_t over the cosine, per eta
};

}  // namespace opaline::gl
