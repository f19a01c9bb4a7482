// What subsurface_texture's CPU and GPU techniques share: settings, and what is made once per scene.
#pragma once

#include "render/subsurface/gloss.h"
#include "render/techniques/technique.h"

namespace opaline {

struct TextureMappingSettings {
  MarchSettings march;
  double epsilon = 0.05;  ///< what is left of light after a neighbourhood's radius
  bool shadows = true;
  bool far_side = true;  ///< is light that comes through from behind looked for?
  bool reflection = false;
  float roughness = 0.3f;
};
std::vector<SettingSpec> texture_mapping_setting_specs();
TextureMappingSettings read_texture_mapping_settings(const Settings& settings);

/// One object, ready to march.
struct MappedObject {
  MarchMedium medium;
  SurfaceFrames frames;
  float reflectance = 0;  ///< of the surface at normal incidence
};

struct MappedScene {
  std::vector<std::unique_ptr<MappedObject>> objects;
  std::vector<MarchLight> lights;
  TextureMappingSettings settings;
  bool unshadowed = false;  ///< nothing can be in shadow, or nobody asks
  Counters counters;

  /// A visible point ready to march; casts rays where something may be in shadow, and to the far side.
  MarchPoint point(const SharedScene& shared, const VisiblePoint& p, MarchCounts& counts) const;
  /// What the marches of an object's points counted, named.
  static Counters named(const MarchCounts& counts, const MappedObject& object);
};
MappedScene make_mapped_scene(const Scene& scene, const TextureMappingSettings& settings);

/// Empty if all objects have layers and the lights are without extent.
std::string texture_mapping_not_applicable(const Scene& scene);

/// The GPU twin of the technique.
std::unique_ptr<PreparedTechnique> prepare_subsurface_texture_gl(const SharedScene& shared, const Settings& settings,
                                                                 const gl::Context& context);

}  // namespace opaline
