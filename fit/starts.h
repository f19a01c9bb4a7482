// Where the searches of a fit begin.
#pragma once

#include "fit/fit_problem.h"

namespace opaline {

/// `initial` first; then points of a Halton sequence over mean free path (against the object's size), albedo and eta,
/// the same for every channel, within the bounds.
std::vector<ParameterVector> start_points(const FitProblem& problem, const ParameterVector& initial);

}  // namespace opaline
