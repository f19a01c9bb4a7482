// The reference: the gather through a tree of clusters, with an error-controlled criterion or the
// published one.
#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  GatherSettings gather;
  gather.criterion = settings.word("criterion") == "solid_angle" ? GatherSettings::Criterion::solid_angle
                                                                 : GatherSettings::Criterion::error;
  gather.max_relative_error = settings.number("max_relative_error");
  gather.quality = settings.number("quality");
  return prepare_gather(shared, settings.word("profile"), gather);
}

}  // namespace

Technique hierarchical_technique() {
  return {"hierarchical",
          "clusters of cells stand for their cells where the estimated error allows it",
          "Jensen, Buhler 2002, \"A Rapid Hierarchical Rendering Technique for Translucent Materials\"",
          {"cpu"},
          "any scene; the error criterion is an estimate, not a bound",
          {profile_setting(),
           {"criterion",
            "error",
            "which clusters are accepted: by estimated error, or by solid angle as published",
            {"error", "solid_angle"}},
           {"max_relative_error", "1e-3", "criterion=error: tolerance relative to each pixel's exitance", {}, 1e-7, 1},
           {"quality", "0.2", "criterion=solid_angle: largest area / distance^2", {}, 1e-6, 100}},
          {.camera = false, .light = true, .material = true, .geometry = true},
          gather_not_applicable,
          prepare};
}

}  // namespace opaline
