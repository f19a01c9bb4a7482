// Which instruction set the vector kernels run on. Kernels are written once against Google Highway,
// compiled for each target and chosen at run time; nothing is built for the building machine.
#pragma once

#include <string>
#include <vector>

namespace opaline {

/// Name of the target in force: "AVX3_SPR", "AVX3", "AVX2", "SSE4", ...
std::string simd_target();

/// Names of the targets this processor can run, best first.
std::vector<std::string> simd_targets();

/// Uses at most that target from now on (tests and benchmarks compare them); "" lifts the limit.
/// Returns false if the processor lacks it. Not thread-safe against running kernels.
bool limit_simd_target(const std::string& name);

}  // namespace opaline
