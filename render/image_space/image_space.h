// Image-space importance sampling (Mertens et al. 2003): what its CPU and GPU techniques share. See
// render/techniques/image_space_sampling.md for the derivation, the misprints and the limits.
#pragma once

#include "render/image_space/irradiance_map.h"
#include "render/image_space/sampled_material.h"
#include "render/techniques/technique.h"

#include <vector>

namespace opaline {

struct ImageSpaceSettings {
  std::string profile;
  int samples = 64, pattern = 4;
  bool light_views = false;  ///< views=camera+light
  int light_view_pixels = 512;
  bool shadow_maps = false;  ///< irradiance=shadow_maps
  int shadow_map_pixels = 2048;
  bool jacobian = true;
  bool only_valid = false;  ///< normalise=valid
  enum class Uniform { near_edges, always, never } uniform = Uniform::near_edges;
  double uniform_share = 0.25;  ///< of the samples, where the uniform set is used
  double min_plane_cosine = 0;  ///< of the plane of the samples, see turned_to
  double disc_flux = 0.95;      ///< share of the profiles' flux inside the disc
};

/// The technique's settings as declared, and as read. Throws InputError for combinations without a meaning.
std::vector<SettingSpec> image_space_setting_specs();
ImageSpaceSettings read_image_space_settings(const Settings& settings);

/// One object's profiles and sample sets.
struct ImageSpaceObject {
  std::vector<SampledMaterial> materials;  ///< of a textured object its representatives
  double disc_radius = 0;                  ///< the largest of them [mm]
  bool textured = false;
};
std::vector<ImageSpaceObject> image_space_objects(const Scene& scene, const ImageSpaceSettings& settings,
                                                  std::uint64_t seed);

/// A view with the light that entered at its points.
struct LitView {
  GBuffer view;
  ViewIrradiance irradiance;
};

/// Adds what is done and spared once per object.
void count_object(const ImageSpaceObject& object, Counters& counters);

/// The irradiance with three channels, whatever it has: what the points of a textured object are summed against.
ViewIrradiance in_colour(const ViewIrradiance& irradiance);

/// B from what the samples of a point summed to (per distinct profile, or per channel of a coloured irradiance) and
/// from the shares of those that met the object (used with normalise=valid).
glm::vec3 exitance_of(const SampledMaterial& material, const ImageSpaceSettings& settings,
                      const ViewIrradiance& irradiance, const float* sums, const float* valid);

/// Which points of the view get the object's combined set: one byte each.
std::vector<std::uint8_t> combined_points(const ImageSpaceObject& object, const ImageSpaceSettings& settings,
                                          const GBuffer& view, const ViewIrradiance& irradiance);

/// All samples of all points of the view, from the camera's own irradiance and that of the other views.
Frame gather_image_space(const Scene& scene, const std::vector<ImageSpaceObject>& objects,
                         const ImageSpaceSettings& settings, const GBuffer& view, const ViewIrradiance& irradiance,
                         const std::vector<LitView>& others);

/// The technique's GPU twin: the gather in a fragment shader, from the camera's irradiance alone.
std::unique_ptr<PreparedTechnique> prepare_image_space_sampling_gl(const SharedScene& shared, const Settings& settings,
                                                                   const gl::Context& context);

}  // namespace opaline
