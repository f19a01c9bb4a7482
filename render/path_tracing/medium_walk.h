// One light path through an object, walked backwards from a point that the camera sees. See path_traced.md.
#pragma once

#include "render/path_tracing/light_chain.h"
#include "render/path_tracing/path_weights.h"

#include <vector>

namespace opaline {

/// Work done, and what was left out by chance or by rounding.
struct PathCounts {
  std::uint64_t walks = 0, scatterings = 0, reflections = 0, exits = 0, roulette_ends = 0, connections = 0,
                searches_skipped = 0, lost = 0;
  SearchCounts search;
  RayCounts rays;
  ChainCounts chain;

  PathCounts& operator+=(const PathCounts& other);
};

/// What the walks in one object share.
struct WalkMedium {
  Interior interior;
  PathChannels channels;
  double g;
  std::vector<LightChains> chains;  ///< per light; that of an environment is never used

  WalkMedium(const Scene& scene, const RayScene& rays, int object, const PathLights& lights);
};

class MediumWalk {
 public:
  MediumWalk(const WalkMedium& medium, const PathLights& lights, RandomStream& random, PathCounts& counts)
      : medium_(medium), lights_(lights), random_(random), counts_(counts), eta_(medium.interior.eta()) {}

  /// One walk's share of the radiance that leaves `point` on `facet` in direction w_o: that of the lead; the sum over
  /// one walk of each lead is an unbiased estimate.
  Rgb radiance(const glm::dvec3& point, std::uint32_t facet, const glm::dvec3& w_o, int lead);

 private:
  struct State {
    glm::dvec3 position, direction;
    PathWeights weights;
    std::uint64_t scatterings = 0;
    std::uint64_t reflections = 0;  // since the last scattering
  };
  struct LampOfWalk {
    Lamp lamp;
    LightChain chain;
  };

  void light_lamps(const glm::dvec3& point);
  Rgb walk(State& state);
  Rgb scattered_light(const State& state);
  Rgb refracted_light(const State& state, std::size_t light, const Lamp& lamp);
  Rgb chain_light(const State& state, std::size_t light);
  Rgb light_outside(const State& state, const Facet& facet);

  const WalkMedium& medium_;
  const PathLights& lights_;
  RandomStream& random_;
  PathCounts& counts_;
  double eta_;
  std::vector<LampOfWalk> lamps_;
};

}  // namespace opaline
