// The whole fit: scenes and pictures in, a material with uncertainties out.
#pragma once

#include "fit/advise.h"
#include "fit/bootstrap.h"
#include "fit/compare_models.h"
#include "fit/defect_correction.h"
#include "fit/diagnosis.h"
#include "fit/solve.h"
#include "fit/surface_bias.h"
#include "fit/target_picture.h"
#include "fit/uncertainty.h"
#include "render/render_scene.h"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

struct FitJob {
  std::vector<std::string> scenes;        ///< one for all targets, or one per target
  std::vector<std::string> targets;       ///< pictures, channels R, G, B or one alone
  std::vector<std::string> masks;         ///< none, one for all, or one per target; first channel > 0: use
  std::string material;                   ///< which of the scene's materials; empty: the only one in use
  std::string model = "transport_table";  ///< in the report: the one that was fitted
  bool exitance_only = false;        ///< transport_table stays exitance where its radiance is known (straight_view.h)
  TargetOptions reading;             ///< of every target; its mask, exposure and repeat come from the lists here
  std::vector<double> exposures;     ///< none, one for all, or one per target
  std::vector<std::string> repeats;  ///< second captures: none, or one per target
  bool scale_free = false;           ///< each target's brightness is known up to a factor
  bool compare_models = false;       ///< fit every isotropic profile to the same operator
  bool profile_intervals = true;     ///< correct intervals where the likelihood is no parabola
  int bootstrap = 0;                 ///< refits with other noise
  bool advise = false;               ///< which further picture would help most
  std::optional<RenderOptions> reference;  ///< whose fit it is to be (defect_correction.h); its `shared` is not read
  CorrectionSettings correction;
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
  double scale = 1;                  ///< the picture is this times the scene's radiance
  NoiseModel noise;
  std::size_t saturated = 0, near_highlights = 0;  ///< pixels left out
  double neighbour_correlation = 0;  ///< of the whitened residual with its right and lower neighbours: 0 for noise
  OperatorError operator_error;      ///< of the refit
  Counters counters;
};

struct FitReport {
  FitJob job;
  Material material;  ///< fitted
  Solution solution;
  Uncertainty uncertainty;
  std::vector<FittedTarget> targets;
  Diagnosis diagnosis;
  std::optional<SurfaceBias> surface;  ///< of the first scene; of fits with transport only
  std::optional<Correction> correction;
  std::optional<ModelComparison> comparison;  ///< of the pictures as they are, without correction
  std::optional<Bootstrap> repetitions;
  std::vector<Advice> advice;
  double operator_seconds = 0, solve_seconds = 0, total_seconds = 0;
};

/// Throws InputError for anything wrong with the input. Coefficients above 1 / r_0 of the operator,
/// which it doesn't resolve, are not searched: report.solution.bounds has the limit in force.
/// progress(stage) is called as stages begin.
FitReport run_fit(const FitJob& job, const ShapeLibrary& shapes,
                  const std::function<void(const std::string& stage)>& progress = {});

/// Of the operator's picture of `material`, on at most `pixels` of its rows, against the hierarchical gather with
/// rigorous bounds of 3e-4 (render/irradiance/irradiance.md), both with the same cells.
OperatorError operator_error(const Scene& scene, const TransportOperator& op, const OperatorSettings& settings,
                             const ProfileInfo& profile, const Material& material, int material_index,
                             std::size_t pixels = 64);
OperatorError operator_error(const Scene& scene, const FitTarget& target, const OperatorSettings& settings,
                             const ProfileInfo& profile, const Material& material, int material_index,
                             std::size_t pixels = 64);

}  // namespace opaline
