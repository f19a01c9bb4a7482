// Transport's radiance along the normal, for a normal pencil beam: what a camera sees that looks straight down on a
// flat, isotropically scattering half space lit straight from above. In the units of a profile,
//   L_o = F_t(1) B/(pi c),   B = R * E   (conventions.h)
// so that every technique and the fit can use it as they use an exitance. A profile of exitance with that lobe spreads
// all light alike over the directions it leaves in. Transport doesn't: near the beam's edge light that was scattered
// once comes straight back and goes nowhere else, and far from it light arrives from the side and leaves towards the
// other. transport_radiance is exact where view and light are along the normal; transport_table is where all directions
// are summed up.
//
//   Rhat = alpha'^2 P exp(Y) + (alpha' c/(8 eta^2)) delta,   c = exit_lobe_normalisation(eta)
//
// with P and Y as in transport_table.h, Y another series (transport_radiance.inc, made by `opaline transport table
// --exit radiance_up`), from radiance_up of searchlight_transform.h. The delta, light scattered once, is spread over
// the core c = 2.5e-4 transport mean free paths. Domain and ends: those of transport_table. The total is what a wide
// flat evenly lit half space shows along its normal, times pi over F_t and E: 1.057 for a white one without a boundary
// (H(1)^2/8), so it may exceed 1.
#pragma once

#include "model/profiles/transport_table.h"

namespace opaline {

std::span<const std::int32_t> transport_radiance_coefficients();

template <typename T>
struct TransportRadiance {
  static constexpr double width = 0.02;  ///< of what stands for the delta [transport mean free paths]
  TransportSeries<T> multiple;
  T once;  ///< flux of the delta

  explicit TransportRadiance(const Medium<T>& medium)
      : multiple(medium, transport_radiance_coefficients()),
        once(multiple.albedo * diffuse_transmittance_external(multiple.eta) / (8.0 * multiple.eta * multiple.eta)) {}

  /// R [1/mm^2] at distance r [mm].
  T evaluate(const T& r) const {
    using std::sqrt;
    const T q = multiple.softened_squared(r), once_rho = sqrt(multiple.softened_squared(r, width));
    const T all = multiple.evaluate(T(sqrt(q)), q) + multiple.core(once, once_rho, width);
    return multiple.sigma_t_prime * multiple.sigma_t_prime * all;
  }

  T core_radius() const { return TransportTableShape::core / multiple.sigma_t_prime; }
};

}  // namespace opaline
