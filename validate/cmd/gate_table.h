// Outcomes of gates for people.
#pragma once

#include "validate/gates.h"

#include <string>

namespace opaline {

/// One line for each gate, what fell short with its value, limit and place.
std::string gate_table(const std::vector<GateResult>& results);

/// How many failed.
std::size_t failed_gates(const std::vector<GateResult>& results);

}  // namespace opaline
