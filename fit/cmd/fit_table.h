// The table a person reads after a fit.
#pragma once

#include "fit/fit_job.h"

#include <optional>
#include <string>

namespace opaline {

/// The true parameters of a synthetic dataset (truth.json). Throws InputError.
ParameterVector read_truth(const std::string& path);

/// Value, 95 % interval and, with a truth, its value, the error and that error in standard
/// deviations; then residual, seconds and notes.
std::string fit_table(const FitReport& report, const std::optional<ParameterVector>& truth);

}  // namespace opaline
