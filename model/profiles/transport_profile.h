// What the profiles with a series of transport_table.h's shape have in common: coefficients in a file made by `opaline
// transport table`, and the registry's row but for what is seen.
#pragma once

#include "model/profiles/numeric_profile.h"
#include "model/profiles/transport_table.h"

#include <ceres/jet.h>

namespace opaline {

/// All of a series: another number of coefficients doesn't compile.
template <std::size_t N>
constexpr std::span<const std::int32_t> whole_series(const std::int32_t (&coefficients)[N]) {
  static_assert(N == TransportTableShape::radii * TransportTableShape::albedos * TransportTableShape::indices);
  return coefficients;
}

/// seen: what of transport, in words that follow "Transport itself".
template <template <typename> class Formula>
ProfileInfo transport_profile(std::string name, const std::string& seen, std::string note) {
  return {.name = std::move(name),
          .citation = "Transport itself" + seen +
                      ": Chandrasekhar's half space with a Fresnel boundary, searchlight by wave numbers (after G. B. "
                      "Rybicki: The Searchlight Problem with Isotropic Scattering, JQSRT 11, 1971)",
          .domain = {.eta_min = TransportTableShape::eta_min,
                     .eta_max = TransportTableShape::eta_max,
                     .alpha_prime_min = 0,
                     .note = std::move(note)},
          .monotone = true,
          .build = &make_numeric_profile<Formula, ceres::Jet<double, 3>>};
}

}  // namespace opaline
