#include "render/machine.h"

#include "model/simd.h"

#include <sched.h>
#include <sys/resource.h>

#include <fstream>

namespace opaline {
namespace {

/// What stands behind "name: " in a file of /proc, or empty.
std::string proc_value(const std::string& path, const std::string& name) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    const std::size_t value = line.find_first_not_of(" \t", line.find(':') + 1);
    if (line.rfind(name, 0) == 0 && value != std::string::npos) return line.substr(value);
  }
  return {};
}

}  // namespace

std::string cpu_device() {
  const std::string model = proc_value("/proc/cpuinfo", "model name");
  return (model.empty() ? "unknown processor" : model) + ", " + simd_target();
}

int cpu_count() {
  cpu_set_t set;
  CPU_ZERO(&set);
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : 1;
}

std::uint64_t peak_rss_bytes() {
  const std::string high_water = proc_value("/proc/self/status", "VmHWM");
  if (!high_water.empty()) return std::stoull(high_water) * 1024;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

bool reset_peak_rss() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5";
  file.close();
  return file.good();
}

std::string compiler_version() {
#if defined(__clang__)
  return "clang " __clang_version__;
#else
  return "g++ " __VERSION__;
#endif
}

}  // namespace opaline
