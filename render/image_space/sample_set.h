// Sample sets on the tangent plane for gathering through a radial profile (Mertens et al. 2003, sections 4 and 6.1).
//
// A set has N samples. Each of the material's distinct channel profiles R_t draws its share of n_t by its own
// importance, area density R_t(r) / rho_t with rho_t its total; a combined set also has n_u samples uniform on the
// disc of radius R'. Every sample serves every channel, weighted by the balance heuristic (Veach & Guibas 1995):
//
//   B_c = sum over samples of weight R_c(|x - p|) E(p) J,   weight = 1 / (sum_t n_t R_t(r') / rho_t + n_u / (pi R'^2))
//
// With one profile and no disc this is rho/N sum R(r_i)/R(r'_i) E J: equation 9 of the paper without the stray 1/(2 pi)
// of its print. Unbiased over the seeds. Within a set the samples follow a low-discrepancy sequence.
//
// Interleaved sampling (Keller & Heidrich 2001): the m x m pixels of a pattern use m^2 different sets.
#pragma once

#include "render/irradiance/profile_gather.h"

#include <cstdint>
#include <vector>

namespace opaline {

/// Samples in a row of floats per field, padded to whole vectors with samples of weight 0.
struct SampleSet {
  std::size_t count = 0;        ///< samples, without padding and those without weight
  std::vector<float> u, v;      ///< place on the tangent plane [mm]
  std::vector<float> weight;    ///< [mm^2]
  std::vector<float> share[3];  ///< weight R_t(r') per distinct profile: sums to rho_t over the plane
};

/// Where the samples of a set come from, as a density on the tangent plane: for combining several views.
struct SampleDensity {
  float per_table[3] = {};  ///< n_t / rho_t
  float on_disc = 0;        ///< n_u / (pi R'^2) [1/mm^2]
  float disc_squared = 0;   ///< R'^2 [mm^2]
};

struct SampleSets {
  int pattern = 1;              ///< m
  std::vector<SampleSet> sets;  ///< m^2
  SampleDensity density;
  std::uint64_t without_weight = 0;  ///< samples left out: so far away that their density underflows

  const SampleSet& of_pixel(int x, int y) const {
    return sets[static_cast<std::size_t>((y % pattern) * pattern + x % pattern)];
  }
};

struct SampleSettings {
  int samples = 64;          ///< N
  int pattern = 4;           ///< m
  double uniform_share = 0;  ///< of N, on the disc; 0: importance alone
  double disc_radius = 0;    ///< R' [mm]
  std::uint64_t seed = 1;
};

SampleSets make_sample_sets(const ChannelProfiles& profiles, const SampleSettings& settings);

/// Radius [mm] of the disc that holds `share` of the flux of each of the profiles, but at most r_max.
double disc_radius(const ChannelProfiles& profiles, double share, double r_max);

}  // namespace opaline
