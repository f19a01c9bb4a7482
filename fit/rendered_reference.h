// A rendering technique as the reference that a fit is corrected by (defect_correction.h).
#pragma once

#include "fit/defect_correction.h"
#include "render/render_scene.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace opaline {

/// Where a target's picture comes from.
struct TargetScene {
  std::shared_ptr<const Scene> scene;
  int material;  ///< of the scene: the fitted one
};

/// Throws InputError if there is no such technique or setting, or it cannot render one of the scenes.
void check_reference(const RenderOptions& options, const std::vector<TargetScene>& scenes);

/// Renders every scene once with the fitted material replaced, and picks the rows of its targets. A statistical
/// technique's variance is the reference's noise; its random numbers are others than the seed of `options` gives,
/// because a synthetic picture made with that would find its own noise again. `base`: the material whose fixed
/// parameters stay. The arguments but `options` must outlive the result.
Reference rendered_reference(const std::vector<TargetScene>& scenes, const std::vector<FitTarget>& targets,
                             const Material& base, const FreeParameters& free, RenderOptions options);

}  // namespace opaline
