#pragma once

namespace opaline {

/// Prints every profile: what it needs beyond a medium, where it holds, its citation.
void list_profiles(bool as_json);

}  // namespace opaline
