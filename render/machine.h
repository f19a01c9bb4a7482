// The machine and this process's memory: what goes beside every measurement.
#pragma once

#include <cstdint>
#include <string>

namespace opaline {

/// Processor model and the vector instructions in use: "Some CPU @ 2.70GHz, AVX3".
std::string cpu_device();

/// Processors this process may run on.
int cpu_count();

/// Largest resident size of this process so far, or since the last reset that worked.
std::uint64_t peak_rss_bytes();

/// Starts peak_rss_bytes anew from the present size; false where the system has no such thing.
bool reset_peak_rss();

/// "g++ 12.2.0", for example.
std::string compiler_version();

}  // namespace opaline
