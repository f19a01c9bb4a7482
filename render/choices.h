// Messages about a name that isn't one of the valid ones: the nearest valid name and all of them.
#pragma once

#include <string>
#include <vector>

namespace opaline {

/// The valid name within edit distance 2 of `given` (ignoring case; nearest, then first), or empty.
std::string nearest_choice(const std::string& given, const std::vector<std::string>& valid);

/// `unknown <kind> "<given>"; did you mean "<nearest>"? valid <kind>s: a, b, c`; the question only
/// when a name is near.
std::string unknown_choice(const std::string& kind, const std::string& given, const std::vector<std::string>& valid);

/// "a, b, c", or "none".
std::string join_names(const std::vector<std::string>& names);

}  // namespace opaline
