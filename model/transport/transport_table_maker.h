// Makes the series of model/profiles/transport_table.h and transport_radiance.h from the deterministic searchlight
// solution.
#pragma once

#include "model/transport/searchlight_transform.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace opaline {

struct SearchlightMixture;

/// Y of transport_table.h at one radius [transport mean free paths], from the solution for absorbed = 1 - alpha'.
double transport_table_value(const SearchlightMixture& mixture, double absorbed, double rho);

struct TransportTableCoefficients {
  std::vector<std::int32_t> values;  ///< [index][albedo][radius], in TransportTableShape::unit
  double worst_residual = 0;         ///< of the mixtures, in units of the expected error
};

/// `progress` is told how many of how many values of eta are done. Takes some minutes on two cores; the same numbers
/// for any number of threads.
TransportTableCoefficients make_transport_table(SearchlightExit exit,
                                                const std::function<void(std::size_t, std::size_t)>& progress);
// Another compiler's rounding lets other terms into the sums of searchlight_mixture.h: it may move coefficients by
// 1e-4, where the solver's own error is.

}  // namespace opaline
