// Shared by the techniques that gather exact cell sums: trees and tables per object.
#pragma once

#include "render/irradiance/profile_gather.h"
#include "render/techniques/technique.h"

namespace opaline {

/// Trees, tables and profile of every object; `settings` decides which clusters are used.
std::unique_ptr<PreparedTechnique> prepare_gather(const SharedScene& shared, const std::string& profile,
                                                  const GatherSettings& settings);

/// The same on the GPU. The tree and the tables are made on the processor.
std::unique_ptr<PreparedTechnique> prepare_gather_gl(const SharedScene& shared, const std::string& profile,
                                                     const GatherSettings& settings, const gl::Context& context);

/// The setting `profile`: any registered one.
SettingSpec profile_setting();

/// Empty if every material of the scene is inside the domain a gather needs.
std::string gather_not_applicable(const Scene& scene);

}  // namespace opaline
