// What was asked of a fit beyond its parameters, as tables a person reads.
#pragma once

#include "fit/fit_job.h"

#include <string>

namespace opaline {

/// Other models, repetitions, advice: those the report has.
std::string examination_table(const FitReport& report);

}  // namespace opaline
