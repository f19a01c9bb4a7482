#include "model/profiles/transport_radiance.h"

#include "model/profiles/numeric_profile.h"

#include <ceres/jet.h>

namespace opaline {
namespace {

constexpr std::int32_t coefficients[] = {
#include "model/profiles/transport_radiance.inc"
};
static_assert(std::size(coefficients) ==
              TransportTableShape::radii * TransportTableShape::albedos * TransportTableShape::indices);

}  // namespace

std::span<const std::int32_t> transport_radiance_coefficients() { return coefficients; }

ProfileInfo transport_radiance_profile() {
  return {
      .name = "transport_radiance",
      .citation =
          "Transport itself seen along the normal: Chandrasekhar's half space with a Fresnel boundary, searchlight by "
          "wave numbers (after G. B. Rybicki: The Searchlight Problem with Isotropic Scattering, JQSRT 11, 1971)",
      .domain = {.eta_min = TransportTableShape::eta_min,
                 .eta_max = TransportTableShape::eta_max,
                 .alpha_prime_min = 0,
                 .note = "radiance along the normal, not exitance: for flat objects lit and seen straight on. Normal "
                         "beam, isotropic scattering, all orders. For g != 0 by similarity, beyond a few transport "
                         "mean free paths"},
      .monotone = true,
      .build = &make_numeric_profile<TransportRadiance, ceres::Jet<double, 3>>,
      .conserves_energy = false,
      .radiance = true};
}

}  // namespace opaline
