// The reference: the gather through a tree of clusters, with an error-controlled criterion or the
// published one.
#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

GatherSettings gather_settings(const Settings& settings) {
  GatherSettings gather;
  gather.criterion = settings.word("criterion") == "solid_angle" ? GatherSettings::Criterion::solid_angle
                                                                 : GatherSettings::Criterion::error;
  gather.max_relative_error = settings.number("max_relative_error");
  gather.quality = settings.number("quality");
  return gather;
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return prepare_gather(shared, settings.word("profile"), gather_settings(settings));
}

std::unique_ptr<PreparedTechnique> prepare_gpu(const SharedScene& shared, const Settings& settings,
                                               const gl::Context& context) {
  return prepare_gather_gl(shared, settings.word("profile"), gather_settings(settings), context);
}

}  // namespace

Technique hierarchical_technique() {
  return {
      .name = "hierarchical",
      .summary = "clusters of cells stand for their cells where the estimated error allows it",
      .citation = "Jensen, Buhler 2002, \"A Rapid Hierarchical Rendering Technique for Translucent Materials\"",
      .backends = {"cpu", "gpu"},
      .limits = "any scene; the error criterion is an estimate, not a bound",
      .settings =
          {profile_setting(),
           {"criterion",
            "error",
            "which clusters are accepted: by estimated error, or by solid angle as published",
            {"error", "solid_angle"}},
           {"max_relative_error", "1e-3", "criterion=error: tolerance relative to each pixel's exitance", {}, 1e-7, 1},
           {"quality", "0.2", "criterion=solid_angle: largest area / distance^2", {}, 1e-6, 100}},
      .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
      .not_applicable = gather_not_applicable,
      .prepare = prepare,
      .prepare_gpu = prepare_gpu,
      .twin_tolerance = 1e-3};
}

}  // namespace opaline
