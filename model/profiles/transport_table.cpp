#include "model/profiles/transport_table.h"

#include "model/profiles/numeric_profile.h"

#include <ceres/jet.h>

namespace opaline {
namespace {

constexpr std::int32_t coefficients[] = {
#include "model/profiles/transport_table.inc"
};
static_assert(std::size(coefficients) ==
              TransportTableShape::radii * TransportTableShape::albedos * TransportTableShape::indices);

}  // namespace

std::span<const std::int32_t> transport_table_coefficients() { return coefficients; }

ProfileInfo transport_table_profile() {
  return {
      .name = "transport_table",
      .citation =
          "Transport itself: Chandrasekhar's half space with a Fresnel boundary, searchlight by wave numbers (after "
          "G. B. Rybicki: The Searchlight Problem with Isotropic Scattering, JQSRT 11, 1971)",
      .domain = {.eta_min = TransportTableShape::eta_min,
                 .eta_max = TransportTableShape::eta_max,
                 .alpha_prime_min = 0,
                 .note = "normal beam, isotropic scattering, all orders: no approximation but the table's; an eta "
                         "outside 1 to 2 is held at the nearer end. For g != 0 it holds by similarity, beyond a few "
                         "transport mean free paths. The 1/r at the axis is smoothed below 2.5e-4 of them"},
      .monotone = true,
      .build = &make_numeric_profile<TransportTable, ceres::Jet<double, 3>>};
}

}  // namespace opaline
