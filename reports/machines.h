// The machines records were measured on.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

/// One sentence for each machine, program and GL renderer.
std::vector<std::string> machine_lines(const std::vector<Record>& records);

}  // namespace opaline
