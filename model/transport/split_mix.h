// SplitMix64 (Steele, Lea & Flood 2014): turns any seed, consecutive ones too, into unrelated 64-bit numbers.
#pragma once

#include <cstdint>

namespace opaline {

struct SplitMix {
  std::uint64_t state;

  std::uint64_t operator()() {
    state += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
};

}  // namespace opaline
