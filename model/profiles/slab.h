// What the multipole of Donner & Jensen 2005 makes of a slab lit by a normal beam: one point source and two
// extrapolated boundaries. multipole.h turns it into R(r) and T(r), layered.h into their Hankel transforms.
//
//   l = 1/sigma_t', D = l/3, s = sigma_tr = sqrt(sigma_a/D), z_b = 2 A D with A of fresnel.h at either side
//   source of strength alpha' at depth l, L = z_b0 + d + z_bd between the extrapolated boundaries
//
// The published model needs d > l, the source inside. Here the source lies at min(l, 2d/3) and has the strength
// alpha' min(1, d/l); what is left of the beam passes unscattered. So nothing changes for d >= 1.5 l, the formulas stay
// finite and positive for any thickness, and a vanishing slab reflects and transmits alpha' d/(2 l) diffusely, as
// single scattering says. Meant to be used for d >= 2 l.
//
// Units: conventions.h; templated on the scalar; sigma_t' and d in [1e-60, 1e60].
#pragma once

#include "model/fresnel.h"

namespace opaline {

/// A homogeneous slab: the medium with its upper boundary's eta, thickness [mm], eta at the lower boundary.
template <typename T>
struct Slab {
  Medium<T> medium;
  T thickness{};
  T eta_below{1};
};

template <typename T>
struct SlabSource {
  T alpha_prime;              ///< 0 .. 1
  T absorbed;                 ///< 1 - alpha'
  T sigma_tr_squared;         ///< [1/mm^2]
  T strength;                 ///< share of the beam that meets a source, 0 .. 1
  T unscattered;              ///< 1 - strength
  T thickness, depth, below;  ///< d; of the source under the upper boundary and above the lower one [mm]
  T z_b0, z_bd;               ///< extrapolation at the top and at the bottom [mm]
  T period;                   ///< L [mm]
  bool infinite;              ///< a half space: thickness, below and period are meaningless

  explicit SlabSource(const Slab<T>& slab) {
    const Medium<T>& m = slab.medium;
    const T sigma_t_prime = m.sigma_a + m.sigma_s_prime, l = 1.0 / sigma_t_prime;
    alpha_prime = m.sigma_s_prime / sigma_t_prime;
    absorbed = m.sigma_a / sigma_t_prime;
    sigma_tr_squared = 3.0 * m.sigma_a * sigma_t_prime;
    thickness = slab.thickness;
    infinite = !(thickness < 1e200);
    const T optical = thickness * sigma_t_prime;
    strength = optical < 1.0 ? optical : T(1.0);
    unscattered = optical < 1.0 ? T(1.0 - optical) : T(0.0);
    depth = optical < 1.5 ? T(thickness * 2.0 / 3.0) : l;
    below = optical < 1.5 ? T(thickness / 3.0) : T(thickness - l);
    z_b0 = 2.0 / 3.0 * l * dipole_boundary_a(m.eta);
    z_bd = 2.0 / 3.0 * l * dipole_boundary_a(slab.eta_below);
    period = thickness + z_b0 + z_bd;
  }
};

}  // namespace opaline
