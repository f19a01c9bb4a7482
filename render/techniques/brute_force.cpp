// The sum over all cells: no clusters. The oracle of every other technique.
#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

GatherChoice gather_choice(const Settings& settings) {
  return {settings.word("profile"), {GatherSettings::Criterion::none, settings.number("cell_error"), 0}};
}

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return prepare_gather(shared, gather_choice(settings));
}

std::unique_ptr<PreparedTechnique> prepare_gpu(const SharedScene& shared, const Settings& settings,
                                               const gl::Context& context) {
  return prepare_gather_gl(shared, gather_choice(settings), context);
}

}  // namespace

Technique brute_force_technique() {
  return {.name = "brute_force",
          .summary = "every cell for every pixel; cells near the pixel are split until they are small",
          .citation = "Jensen, Marschner, Levoy, Hanrahan 2001, \"A Practical Model for Subsurface Light Transport\"",
          .backends = {"cpu", "gpu"},
          .limits = "any scene; time grows with pixels x cells",
          .settings = {profile_setting(),
                       {"cell_error", "1e-5", "relative error below which a cell stays whole", {}, 1e-9, 1}},
          .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
          .not_applicable = gather_not_applicable,
          .prepare = prepare,
          .prepare_gpu = prepare_gpu,
          .twin_tolerance = 2e-5};
}

}  // namespace opaline
