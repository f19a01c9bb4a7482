// The sum over all cells: no clusters. The oracle of every other technique.
#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  GatherSettings gather;
  gather.criterion = GatherSettings::Criterion::none;
  gather.max_relative_error = settings.number("cell_error");
  return prepare_gather(shared, settings.word("profile"), gather);
}

}  // namespace

Technique brute_force_technique() {
  return {"brute_force",
          "every cell for every pixel; cells near the pixel are split until they are small",
          "Jensen, Marschner, Levoy, Hanrahan 2001, \"A Practical Model for Subsurface Light Transport\"",
          {"cpu"},
          "any scene; time grows with pixels x cells",
          {profile_setting(), {"cell_error", "1e-5", "relative error below which a cell stays whole", {}, 1e-9, 1}},
          {.camera = false, .light = true, .material = true, .geometry = true},
          gather_not_applicable,
          prepare};
}

}  // namespace opaline
