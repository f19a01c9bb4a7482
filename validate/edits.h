// What a frame costs after an edit of the scene: the edit is made, and everything it invalidates is made again.
//
//   camera    turned about what it looks at by 2 degrees: the view; prepare only for techniques that say so
//   light     the first light turned by 2 degrees (a directional one), moved by a hundredth of its distance, or dimmed
//   (an
//             environment): cells and irradiance, for techniques that use them
//   material  sigma_a times 1.1: nothing that is shared
//   geometry  the first object 1 % larger: rays, view, cells and irradiance
#pragma once

#include "validate/record.h"
#include "validate/technique_run.h"
#include "validate/warm_times.h"

namespace opaline {

/// Makes the edit once and renders a frame, which is in `run` then; prepares where the technique says that the edit
/// needs it, or what is prepared refuses the edited scene, or `anyway`; else `run` must be prepared. The scene and its
/// shared parts are as before when it returns, with nothing prepared.
EditCost measure_edit_once(const std::string& edit, TechniqueRun& run, bool anyway = false);

/// Measures the edit as often as `plan` says; the result is the run of median total. The scene and its shared parts are
/// as before when it returns; `run` may be prepared or not, and isn't when it returns. `spent` gains the seconds of all
/// runs.
EditCost measure_edit(const std::string& edit, TechniqueRun& run, const TimingPlan& plan, double& spent);

}  // namespace opaline
