// Light that is reflected inside the boundary, once or more, before it is scattered for the first time. (Light that
// isn't is found by FacetTree, all of it.) It matters where a medium is thin.
//
// A chain is a facet where light enters and the facets that then reflect it, in order. Mirror images straighten it: a
// point inside sees the light through a chain along at most one ray, and a test decides. Chains are too many to test
// all, so one is drawn: a facet by its light and its distance from the path, a point on it, and the facets that the ray
// from there meets. Every point of a path is tested against all beginnings of the chain, and what it finds is divided
// by the probability of the chain. That one has a known part (the facet, going on after each reflection) and an unknown
// one: the share q of the facet's area from which the ray meets this chain. 1/q is the mean number of draws until that
// happens again, so the number of draws of one such trial takes its place, without bias (as Booth 2007 and Zeltner,
// Georgiev & Jakob 2020 do).
#pragma once

#include "render/path_tracing/interior.h"
#include "render/path_tracing/path_lights.h"

#include <vector>

namespace opaline {

struct ChainCounts {
  std::uint64_t chains = 0, links = 0, trials = 0, trials_given_up = 0;
};

struct LightChain {
  std::uint32_t entry = 0;
  double entry_probability = 0;
  std::vector<std::uint32_t> mirrors;
  std::vector<double> survival;  ///< probability that the chain got as far as that mirror
};

/// Light at a point by way of a chain.
struct ChainLight {
  RefractedRay ray;            ///< at the mirrored point; its length is that of all segments
  glm::dvec3 u;                ///< direction at the point itself, towards the last mirror
  double reflectance = 0;      ///< product over the mirrors
  std::size_t mirrors = 0;     ///< how many of the chain's
  double inverse_density = 0;  ///< an unbiased estimate of one over the chain's probability
};

class LightChains {
 public:
  /// No chains: for an environment, whose light is found by paths that leave.
  explicit LightChains(const Interior& interior) : interior_(&interior) {}
  /// For one light that isn't an environment. `extinction`: the smallest of the medium; it only guides how long
  /// chains get.
  LightChains(const Interior& interior, const PathLights& lights, std::size_t light, double extinction);

  /// Empty (no mirrors) where there is none, as at eta = 1.
  /// `near`: where the path is about; chains that start there are drawn more often.
  LightChain draw(const Lamp& lamp, const glm::dvec3& near, RandomStream& random, RayCounts& rays,
                  ChainCounts& counts) const;

  /// Calls visit(ChainLight) for each beginning of the chain through which y sees the lamp.
  template <typename Visit>
  void for_each_light(const LightChain& chain, const Lamp& lamp, const glm::dvec3& y, RandomStream& random,
                      RayCounts& rays, ChainCounts& counts, Visit&& visit) const {
    std::vector<glm::dvec3> corners;
    for (std::size_t k = 1; k <= chain.mirrors.size(); ++k) {
      ChainLight light;
      if (!straighten(chain, k, lamp, y, light, corners) || !is_free(chain, light, corners, rays)) continue;
      light.inverse_density =
          draws_until_met(chain, k, lamp, random, rays, counts) / (chain.entry_probability * chain.survival[k - 1]);
      visit(light);
    }
  }

 private:
  bool straighten(const LightChain& chain, std::size_t mirrors, const Lamp& lamp, const glm::dvec3& y,
                  ChainLight& light, std::vector<glm::dvec3>& corners) const;
  bool is_free(const LightChain& chain, const ChainLight& light, const std::vector<glm::dvec3>& corners,
               RayCounts& rays) const;
  double draws_until_met(const LightChain& chain, std::size_t mirrors, const Lamp& lamp, RandomStream& random,
                         RayCounts& rays, ChainCounts& counts) const;
  bool meets(const LightChain& chain, std::size_t mirrors, const Lamp& lamp, RandomStream& random,
             RayCounts& rays) const;

  const Interior* interior_;
  std::vector<double> light_, sums_;  // per facet an estimate of its light, per node of the tree; empty if none
  double going_on_ = 0, scale_ = 0;
};

}  // namespace opaline
