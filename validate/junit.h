// Results of a run in the format that continuous integrations read (JUnit XML).
#pragma once

#include "validate/gates.h"

#include <string>
#include <vector>

namespace opaline {

/// Two test suites: one test case for each gate, and one for each cell, where a failed cell is an error and one that is
/// not applicable is skipped.
std::string junit_xml(const std::string& suite, const std::vector<GateResult>& gates,
                      const std::vector<Record>& records);

}  // namespace opaline
