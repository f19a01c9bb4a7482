// The table a person reads after a fit.
#pragma once

#include "fit/fit_job.h"

#include <optional>
#include <string>

namespace opaline {

/// The true parameters of a synthetic dataset (truth.json). Throws InputError.
ParameterVector read_truth(const std::string& path);

/// A sentence if the dataset was rendered with another profile than `model`, so that its true values are not what a fit
/// with that model tends to; else empty.
std::string truth_warning(const std::string& path, const std::string& model);

/// Value, 95 % interval and, with a truth, its value, the error and that error in standard
/// deviations; then residual, seconds and notes.
std::string fit_table(const FitReport& report, const std::optional<ParameterVector>& truth);

}  // namespace opaline
