#include "model/profiles/transport_table.h"

#include "model/profiles/transport_profile.h"

namespace opaline {
namespace {

constexpr std::int32_t coefficients[] = {
#include "model/profiles/transport_table.inc"
};

}  // namespace

std::span<const std::int32_t> transport_table_coefficients() { return whole_series(coefficients); }

ProfileInfo transport_table_profile() {
  return transport_profile<TransportTable>(
      "transport_table", "",
      "normal beam, isotropic scattering, all orders: no approximation but the table's; an eta outside 1 to 2 is held "
      "at the nearer end. For g != 0 it holds by similarity, beyond a few transport mean free paths. The 1/r at the "
      "axis is smoothed below 2.5e-4 of them");
}

}  // namespace opaline
