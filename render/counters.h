// Work done and work skipped, by name. Counts are exact where seconds are not.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace opaline {

struct Counters {
  std::map<std::string, std::uint64_t> done, skipped;

  Counters& operator+=(const Counters& other) {
    for (const auto& [name, count] : other.done) done[name] += count;
    for (const auto& [name, count] : other.skipped) skipped[name] += count;
    return *this;
  }
};

}  // namespace opaline
