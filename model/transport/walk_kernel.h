// The inner loop of the white walk: many photons side by side, one per vector lane, from entry to exit.
// Internal to model/transport; use walk.h.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace opaline {

/// What all walks of a run share. Lengths in mean free paths.
struct WalkConstants {
  float g = 0;                        // mean scattering cosine (Henyey-Greenstein)
  float thickness = 0;                // of the slab; infinity for a half space
  float sine = 0, cosine = 1;         // the beam's direction inside, (sine, 0, cosine), z inwards
  float index_squared = 1;            // max(eta, 1)^2
  std::vector<float> reflectance;     // by the cosine on the thin side, evenly spaced over [0, 1]; empty at eta = 1
  std::int32_t last_survivor = 0;     // roulette: the walk goes on with probability (last_survivor + 1)/2^31 ...
  std::int32_t free_scatterings = 0;  // ... at every scattering after that many
};

/// A buffer of walks that have ended.
struct WalkEnds {
  enum How : std::int32_t { reflected, transmitted, killed };
  static constexpr int shift = 2;
  static constexpr std::size_t capacity = 4096, slack = 256;

  std::size_t size = 0;
  float r2[capacity + slack];          // squared distance of the exit from the entry
  std::int32_t key[capacity + slack];  // scatterings << shift | How
};

/// Walks `walks` photons to their end, handing over full buffers, and returns the number of scatterings. The same
/// seed gives the same walks on one vector target; another target takes another, equally good sample.
std::uint64_t run_walks(const WalkConstants& constants, std::uint64_t seed, std::uint64_t walks,
                        const std::function<void(const WalkEnds&)>& sink);

}  // namespace opaline
