// Importance samples on the tangent plane, projected into an image of the irradiance.
#include "render/image_space/image_space.h"
#include "render/image_space/light_views.h"
#include "render/image_space/sample_gather.h"
#include "render/input_error.h"
#include "render/techniques/gather_technique.h"
#include "render/visibility/convexity.h"

namespace opaline {
namespace {

class PreparedSampling : public PreparedTechnique {
 public:
  PreparedSampling(const SharedScene& shared, const ImageSpaceSettings& settings)
      : shared_(shared),
        settings_(settings),
        unshadowed_(nothing_in_shadow(shared.scene)),
        objects_(image_space_objects(shared.scene, settings, shared.settings.irradiance.seed)) {
    if (!settings.light_views) return;
    for (GBuffer& view : light_views(shared.scene, shared.rays, settings.light_view_pixels, prepare_counters_))
      lights_.push_back({std::move(view), {}});
    if (lights_.size() >= SampleGather::max_views)
      throw InputError("--set views", "", "camera+light takes at most 15 lights with a view of their own");
    for (LitView& light : lights_) light.irradiance = irradiance(light.view, prepare_counters_);
  }

  Frame render(const GBuffer& view) const override {
    Counters counters = prepare_counters_;
    const ViewIrradiance camera = irradiance(view, counters);
    Frame frame = gather_image_space(shared_.scene, objects_, settings_, view, camera, lights_);
    frame.counters += counters;
    return frame;
  }

 private:
  ViewIrradiance irradiance(const GBuffer& view, Counters& counters) const {
    return view_irradiance(shared_.scene, shared_.rays, view, shared_.settings.irradiance, unshadowed_, counters);
  }

  const SharedScene& shared_;
  ImageSpaceSettings settings_;
  bool unshadowed_;
  std::vector<ImageSpaceObject> objects_;
  std::vector<LitView> lights_;
  Counters prepare_counters_;
};

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  const ImageSpaceSettings read = read_image_space_settings(settings);
  if (read.shadow_maps) throw InputError("--set irradiance", "", "shadow maps need --backend gpu");
  return std::make_unique<PreparedSampling>(shared, read);
}

}  // namespace

Technique image_space_sampling_technique() {
  return {.name = "image_space_sampling",
          .summary = "importance samples on each pixel's tangent plane, projected into an image of the irradiance",
          .citation =
              "Mertens, Kautz, Bekaert, Van Reeth, Seidel 2003, \"Efficient Rendering of Local Subsurface Scattering\"",
          .backends = {"cpu", "gpu"},
          .limits =
              "gathers only light that enters where the camera (or, with views=camera+light, a light) sees the "
              "object; needs all pixels of the view; the gpu backend has the camera's view alone",
          .settings = image_space_setting_specs(),
          .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
          .not_applicable = gather_not_applicable,
          .prepare = prepare,
          .needs_irradiance = false,
          .only_visible = true,
          .prepare_gpu = prepare_image_space_sampling_gl,
          .twin_tolerance = 5e-4,
          .materials = {MaterialKind::homogeneous, MaterialKind::textured}};
}

}  // namespace opaline
