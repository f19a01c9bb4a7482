// Intervals from the likelihood itself, where its logarithm is no parabola.
#pragma once

#include "fit/fit_problem.h"
#include "fit/uncertainty.h"

namespace opaline {

/// For every free parameter: where the best fit with that parameter held is worse than the solution by 1.92 in half
/// chi-squared (95 %). Ends that the parabola predicts within 5 % of that are kept as they are; a side that never gets
/// there ends at the bound. Estimates that were moved say interval = "profile". Only for fits by least squares: the
/// sandwich of a robust loss has no likelihood behind it.
void profile_intervals(const FitProblem& problem, const Solution& solution, Uncertainty& u);

}  // namespace opaline
