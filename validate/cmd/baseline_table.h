// A run against its baseline for people.
#pragma once

#include "validate/baseline.h"

#include <string>

namespace opaline {

/// Worse first, then better, then changed counters.
std::string baseline_table(const BaselineComparison& comparison);

}  // namespace opaline
