// The outcome of a run for people.
#pragma once

#include "validate/matrix.h"

#include <string>

namespace opaline {

/// One line for each technique and setting of each scene: times, errors, or why there are none.
std::string run_table(const RunSummary& summary);

/// How many cells were done and how many measured now, the time that took, and the harness's part of it.
std::string run_totals(const Suite& suite, const RunOptions& options, const RunSummary& summary);

/// How far the times of two measurements of the same cells differ.
std::string repeat_table(const RunSummary& first, const RunSummary& second);

}  // namespace opaline
