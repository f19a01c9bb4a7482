// How a reference's picture answers to the parameters, in the operator's terms: A with J_reference = J_operator A, by
// least squares over the whitened pictures, from secants of both.
#pragma once

#include "fit/defect_correction.h"
#include "fit/fit_problem.h"

namespace opaline {

/// Parameters that one render may move together, for they show in different channels.
std::vector<std::vector<int>> parameter_groups(const FitProblem& problem);

/// `made`: the reference's pictures at `at`. One more render for each group. Directions that the data do not show (or,
/// of a noisy reference, that its noise would drown) keep the operator's own derivatives.
Eigen::MatrixXd reference_sensitivity(const FitProblem& problem, const std::vector<Whitened>& weights,
                                      const FitPoint& at, const std::vector<ReferencePicture>& made,
                                      const Reference& reference);

}  // namespace opaline
