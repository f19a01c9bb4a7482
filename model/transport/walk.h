// Monte-Carlo truth for plane media: a pencil beam falls on a half space or a slab with smooth faces, and photons
// walk until they leave. No cap on scatterings and no bias.
//
// Two levels:
//   walk_half_space, walk_slab   one medium, in mm
//   white_walk + searchlight_at  mean free paths; ONE walk serves every albedo: paths are made at unit albedo, and a
//                                path that leaves after n scatterings counts albedo^n. (For g = 0 a mean free path
//                                is a transport mean free path 1/sigma_t' at every albedo, so that one walk per eta
//                                gives the whole family R(r; alpha').)
// Endless paths are ended by roulette: after `free_scatterings`, every scattering is survived with probability
// `roulette_albedo`, and albedo^n is divided by the chance to have survived. That is unbiased for every albedo, and
// the weights stay bounded for albedo <= roulette_albedo.
//
// Conventions: Henyey-Greenstein scattering with mean cosine g; faces of relative index eta = inside / outside,
// the same outside on both sides; unpolarised Fresnel reflection at every crossing; the beam is infinitely thin, comes
// in with `cos_incident` OUTSIDE (measured from the normal), and r is the distance from its entry point (on the far
// face: from the point opposite).
//
// Precision: positions, directions and the Fresnel table are floats; the table is linear between 2049 entries, within
// 6e-6 of model/fresnel.h for 1.05 <= max(eta, 1/eta) <= 3. Totals of 1e9 walks show no deviation from h_function.h at
// standard errors of 5e-6 to 1.6e-5.
//
// The same seed gives the same bits for any number of threads (fixed batches of walks, each with its own stream;
// results are whole-number counts); another vector target (simd.h) takes another, equally good sample. Wrong arguments
// throw std::invalid_argument.
#pragma once

#include "model/conventions.h"
#include "model/transport/walk_counts.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace opaline {

/// A mean over walks and its standard error.
struct Estimate {
  double value = 0, standard_error = 0;
};

/// Mean over one annulus inner <= r < outer.
struct AnnulusEstimate {
  double inner = 0, outer = 0;
  Estimate exitance;  // per area: [1/mm^2], or per squared mean free path
  Estimate once;      // its part that was scattered exactly once
};

/// Everything is PER TRANSMITTED FLUX (per unit of flux that has entered) and WITHOUT the specular reflection of
/// the beam, unless the name says otherwise.
struct SearchlightResult {
  double specular = 0;  // Fresnel reflectance of the beam, per incident flux

  Estimate reflected, transmitted, absorbed;  // totals, unscattered light included
  Estimate balance;                           // their sum: 1 within its error
  Estimate unscattered_reflected, unscattered_transmitted;
  Estimate once_reflected, once_transmitted;                // scattered exactly once
  std::vector<AnnulusEstimate> reflectance, transmittance;  // by annulus, scattered light alone
  std::uint64_t walks = 0, scatterings = 0;

  double per_incident(double per_transmitted) const { return (1 - specular) * per_transmitted; }
  Estimate reflected_per_incident() const;
  Estimate reflected_per_incident_with_specular() const;
  Estimate transmitted_per_incident() const;
};

/// A run of white walks, lengths in mean free paths.
struct WhiteWalk {
  double g = 0;                                                        // in (-1, 1)
  double eta = 1;                                                      // > 0
  double optical_thickness = std::numeric_limits<double>::infinity();  // > 0
  double cos_incident = 1;                                             // in (0, 1]
  double roulette_albedo = 0.99;                                       // in (0, 1]; below 1 for a half space
  std::uint32_t free_scatterings = 0;
  std::vector<double> radii;  // edges of annuli, ascending, >= 0
  std::uint64_t walks = 1 << 20, seed = 1;
};

WalkCounts white_walk(const WhiteWalk& walk);

/// The result for one albedo sigma_s/sigma_t in [0, 1] (at most roulette_albedo, or the errors grow without bound).
SearchlightResult searchlight_at(const WalkCounts& counts, double albedo);

/// One medium, in mm.
struct Searchlight {
  Medium<double> medium;
  double g = 0;
  double cos_incident = 1;
  std::vector<double> radii;  // [mm]
  std::uint64_t walks = 1 << 20, seed = 1;
};

SearchlightResult walk_half_space(const Searchlight& searchlight);
SearchlightResult walk_slab(const Searchlight& searchlight, double thickness_mm);

}  // namespace opaline
