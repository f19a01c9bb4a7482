// Blocks as Markdown (GitHub's, for its tables): for a pull request or a job's summary.
#pragma once

#include "reports/document.h"

namespace opaline {

/// Text that Markdown leaves as it is: \ ` * _ { } [ ] < > # | ~ ! $ are escaped, line ends become spaces.
std::string markdown_escaped(const std::string& text);

std::string markdown(const Block& block);
std::string markdown(const Chapter& chapter);

}  // namespace opaline
