// A fit that agrees with a renderer instead of the operator alone. The operator is a fast model of the picture, the
// renderer a slow one that knows more: the gather without the operator's interpolation, or path tracing, which knows
// that surfaces bend and that light falls obliquely. The data are corrected by what the operator gets wrong at theta,
//
//   t - (reference(theta) - operator(theta)),
//
// and theta moves by Levenberg-Marquardt with the operator's derivatives J, until J^T (reference(theta) - t) = 0: the
// reference's own fit, but for weights that are a little less than the best. That takes a few renders instead of one
// for every derivative ("defect correction": Stetter 1978; "space mapping" in design: Bandler et al. 2004).
//
// Where the operator is far off, its derivatives are too. Then a few more renders beside theta give the matrix A with
// J_reference = J A in the directions that the data see ("manifold mapping": Echeverria, Hemker 2005). Steps use J A,
// and so does the covariance: with weights J^T it is exactly ((J A)^T J A)^-1.
#pragma once

#include "fit/solve.h"

#include <functional>
#include <vector>

namespace opaline {

/// A target's rows x channels as the reference makes them, without the target's scale, and their noise.
struct ReferencePicture {
  Eigen::MatrixXd rows;
  NoiseModel noise;
};

/// All targets' pictures of a material. The same random numbers in every call, so that differences are small.
using Reference = std::function<std::vector<ReferencePicture>(const ParameterVector& parameters)>;

struct CorrectionSettings {
  int max_steps = 10;
  /// A is measured where the operator's picture is further than this from the reference's (relative RMS).
  double measure_from = 0.01;
  /// The search ends where the next step would be shorter than this many standard deviations for the root of each free
  /// parameter,
  double small_step = 0.1;
  double small_step_of_noisy = 1;  ///< instead, where every picture of the reference has its own noise
  double least_step = 1e-5;        ///< or move no parameter's ln (of eta: the value) by more than this
};

struct CorrectionStep {
  ParameterVector at{};     ///< what was rendered
  double defect = 0;        ///< RMS of reference - operator over the RMS of the reference, all targets
  double residual = 0;      ///< RMS of reference - data over the RMS of the data
  double next_step_sd = 0;  ///< length of the full step from there in standard deviations
  bool better = true;       ///< than all before; if not, the search went back
};

struct Correction {
  std::vector<CorrectionStep> steps;
  bool converged = false;
  int renders = 0;
  int renders_saved = 0;  ///< of the measurement of A, where the operator was near enough without
  bool measured = false;
  /// A, of the solver's parameters and the free ln scales; 1 if not measured.
  Eigen::MatrixXd sensitivity;
  double seconds = 0;
};

/// `found`: the fit without correction; it becomes the corrected fit, with the Jacobian J A. The targets keep their
/// corrected pictures, FitTarget::offset what was taken off, and noise that holds the reference's where it is known.
Correction correct_by_reference(std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
                                const SolveSettings& settings, const Reference& reference,
                                const CorrectionSettings& correction, Solution& found);

}  // namespace opaline
