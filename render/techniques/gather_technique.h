// Shared by the techniques that gather exact cell sums: trees and tables per object.
#pragma once

#include "render/irradiance/discretisation.h"
#include "render/techniques/technique.h"

namespace opaline {

/// How the integral over the surface becomes a sum.
struct GatherChoice {
  std::string profile;
  GatherSettings clusters;
  /// 0: the cells of the shared scene as they are; else finer ones where they aren't good enough (discretisation.h).
  double discretisation_error = 0;
};

/// One object's cells and tree.
struct GatherSurface {
  Discretisation own;         ///< its tree is the one used; its cells are empty where the shared ones do
  const SurfaceCells* cells;  ///< those of the tree
};
std::unique_ptr<GatherSurface> gather_surface(const SharedScene& shared, std::size_t object,
                                              const ChannelProfiles& profiles, const GatherChoice& choice,
                                              Counters& counters);

/// Trees, tables and profile of every object. The frame's estimate "discretisation_error" is that of the worst object.
std::unique_ptr<PreparedTechnique> prepare_gather(const SharedScene& shared, const GatherChoice& choice);

/// The same on the GPU. The tree and the tables are made on the processor.
std::unique_ptr<PreparedTechnique> prepare_gather_gl(const SharedScene& shared, const GatherChoice& choice,
                                                     const gl::Context& context);

/// The setting `profile`: any registered one.
SettingSpec profile_setting();

/// Empty if every material of the scene is inside the domain a gather needs.
std::string gather_not_applicable(const Scene& scene);

}  // namespace opaline
