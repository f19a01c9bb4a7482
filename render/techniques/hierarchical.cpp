// The reference: the gather through a tree of clusters, accepted by the error of doing so (an estimate, or a rigorous
// bound) or as published. The frame's image "bound" holds whichever of the first two decides.
#include "render/input_error.h"
#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

GatherChoice gather_choice(const Settings& settings) {
  GatherSettings gather;
  const std::string& criterion = settings.word("criterion");
  gather.criterion = criterion == "solid_angle" ? GatherSettings::Criterion::solid_angle
                     : criterion == "bound"     ? GatherSettings::Criterion::bound
                                                : GatherSettings::Criterion::error;
  gather.max_relative_error = settings.number("max_relative_error");
  gather.quality = settings.number("quality");
  // As published, the cells are those given.
  const bool controlled = settings.word("discretisation") == "controlled" && criterion != "solid_angle";
  return {settings.word("profile"), gather, controlled ? gather.max_relative_error : 0};
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return prepare_gather(shared, gather_choice(settings));
}

std::unique_ptr<PreparedTechnique> prepare_gpu(const SharedScene& shared, const Settings& settings,
                                               const gl::Context& context) {
  if (settings.word("criterion") == "bound")
    throw InputError("--set", "criterion=bound",
                     "bounds are made on the processor alone: take --backend cpu, or one of error, solid_angle");
  return prepare_gather_gl(shared, gather_choice(settings), context);
}

}  // namespace

Technique hierarchical_technique() {
  return {.name = "hierarchical",
          .summary = "clusters of cells stand for their cells where the estimated error allows it",
          .citation = "Jensen, Buhler 2002, \"A Rapid Hierarchical Rendering Technique for Translucent Materials\"",
          .backends = {"cpu", "gpu"},
          .limits =
              "any scene; returns a bound of its own error beside the image, except with criterion=solid_angle and on "
              "the GPU",
          .settings =
              {profile_setting(),
               {"criterion",
                "error",
                "which clusters are accepted: by an estimate of the error, by its rigorous bound, or by solid angle as "
                "published",
                {"error", "bound", "solid_angle"}},
               {"max_relative_error",
                "1e-3",
                "criterion=error, bound: tolerance relative to each pixel's exitance; discretisation=controlled: "
                "relative to the exitance of each object as a whole",
                {},
                1e-7,
                1},
               {"discretisation",
                "controlled",
                "cells: finer where those given (--samples) are not good enough, or as they are (always so with "
                "criterion=solid_angle)",
                {"controlled", "fixed"}},
               {"quality", "0.2", "criterion=solid_angle: largest area / distance^2", {}, 1e-6, 100}},
          .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
          .not_applicable = gather_not_applicable,
          .prepare = prepare,
          .prepare_gpu = prepare_gpu,
          .twin_tolerance = 1e-3};
}

}  // namespace opaline
