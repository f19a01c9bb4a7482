#include "model/profiles/transport_radiance.h"

#include "model/profiles/transport_profile.h"

namespace opaline {
namespace {

constexpr std::int32_t coefficients[] = {
#include "model/profiles/transport_radiance.inc"
};

}  // namespace

std::span<const std::int32_t> transport_radiance_coefficients() { return whole_series(coefficients); }

ProfileInfo transport_radiance_profile() {
  ProfileInfo info = transport_profile<TransportRadiance>(
      "transport_radiance", " seen along the normal",
      "radiance along the normal, not exitance: for flat objects lit and seen straight on. Normal beam, isotropic "
      "scattering, all orders. For g != 0 by similarity, beyond a few transport mean free paths");
  info.conserves_energy = false;
  info.radiance = true;
  return info;
}

}  // namespace opaline
