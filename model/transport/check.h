// The walk against numbers it does not know: published totals, and the exact ones of h_function.h.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace opaline {

struct TransportCheckRow {
  std::string name;
  double expected = 0, expected_error = 0;  // standard error (or rounding) of the number compared with
  double reached = 0, standard_error = 0;

  /// Deviation in standard errors of both.
  double z() const;
};

/// One row per total, `walks` walks for each group of rows. With 1e8 walks the standard errors are below 1e-4
/// and it takes some minutes of processor time; every |z| should be below 4.
std::vector<TransportCheckRow> transport_check(std::uint64_t walks, std::uint64_t seed = 1);

}  // namespace opaline
