// Another renderer as a technique: a command that reads a scene file and writes an EXR.
#pragma once

#include "render/image.h"

#include <cstdint>
#include <string>

namespace opaline {

struct ExternalRun {
  Image image;
  std::string command;  ///< as it was run
  double seconds = 0;   ///< of the whole process
  std::uint64_t peak_rss_bytes = 0;
};

/// Runs the command by /bin/sh in `folder`, with {scene} replaced by `scene` and {out} by a file of that stem, and
/// reads what it wrote. Throws std::runtime_error with the exit status and the end of its output when it fails, or
/// wrote none.
ExternalRun run_external(const std::string& command, const std::string& folder, const std::string& scene,
                         const std::string& stem);

}  // namespace opaline
