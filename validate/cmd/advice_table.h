// The fronts of error against time for people.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

/// For each scene and material, the techniques and settings that no other beats in time and relative_rmse.
std::string front_table(const std::vector<Record>& records);

}  // namespace opaline
