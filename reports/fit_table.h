// fit.json in words and as a table.
#pragma once

#include "reports/document.h"
#include "reports/report_data.h"

namespace opaline {

/// Model, convergence, residual, noise, seconds; bad when it did not converge.
Paragraph fit_sentence(const FitResult& fit);

/// True (where known), recovered, 95 % interval, error, and the error in standard deviations, one row per parameter and
/// channel. A parameter that could not be determined says why.
Table fit_table(const FitResult& fit);

/// What the fit itself remarks.
std::vector<std::string> fit_notes(const FitResult& fit);

}  // namespace opaline
