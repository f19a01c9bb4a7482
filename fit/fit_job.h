// The whole fit: scenes and pictures in, a material with uncertainties out.
#pragma once

#include "fit/solve.h"
#include "fit/uncertainty.h"
#include "render/scene/scene.h"

#include <functional>
#include <string>
#include <vector>

namespace opaline {

struct FitJob {
  std::vector<std::string> scenes;   ///< one for all targets, or one per target
  std::vector<std::string> targets;  ///< linear pictures (EXR), channels R, G, B
  std::vector<std::string> masks;    ///< none, one for all, or one per target; first channel > 0: use
  std::string material;              ///< which of the scene's materials; empty: the only one in use
  std::string model = "standard_dipole";
  OperatorSettings op;
  SolveSettings solve;
};

/// How far an operator's picture is from the sum over the very cells it was made of, relative to the picture's RMS.
struct OperatorError {
  double rms = 0;  ///< against a fresh gather
  double at_most =
      0;  ///< rigorous where the gather's bound is: each pixel's difference, and what the gather may be off
};

/// One target after the fit.
struct FittedTarget {
  std::string scene, target;
  Image picture, refit, difference;  ///< RGBA; difference = refit - picture, alpha 1 where fitted
  OperatorError operator_error;      ///< of the refit
  Counters counters;
};

struct FitReport {
  FitJob job;
  Material material;  ///< fitted
  Solution solution;
  Uncertainty uncertainty;
  std::vector<FittedTarget> targets;
  double operator_seconds = 0, solve_seconds = 0, total_seconds = 0;
};

/// Throws InputError for anything wrong with the input. Coefficients above 1 / r_0 of the operator,
/// which it doesn't resolve, are not searched: report.solution.bounds has the limit in force.
/// progress(stage) is called as stages begin.
FitReport run_fit(const FitJob& job, const ShapeLibrary& shapes,
                  const std::function<void(const std::string& stage)>& progress = {});

/// Of the operator's picture of `material`, on at most `pixels` of its rows, against the hierarchical gather with
/// rigorous bounds of 1e-4 (render/irradiance/irradiance.md), both with the same cells.
OperatorError operator_error(const Scene& scene, const TransportOperator& op, const OperatorSettings& settings,
                             const ProfileInfo& profile, const Material& material, int material_index,
                             std::size_t pixels = 256);

}  // namespace opaline
