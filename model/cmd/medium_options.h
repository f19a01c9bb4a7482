// What the commands of this folder read from the command line beyond plain values. Each function
// throws std::invalid_argument, whose message names the option and the valid choices.
#pragma once

#include "model/conventions.h"

#include <limits>
#include <string>
#include <vector>

namespace opaline {

/// A medium per channel: a material of the library, or coefficients.
struct MediumOptions {
  std::string material;                                   ///< --material
  std::vector<double> sigma_a, sigma_s_prime;             ///< one or three numbers [1/mm]
  double eta = std::numeric_limits<double>::quiet_NaN();  ///< --eta; NaN: not given
  double g = 0;                                           ///< --g: checked only, no profile depends on it
};

/// Throws std::invalid_argument(message) unless `good`.
void require_argument(bool good, const std::string& message);

/// One medium, or three: red, green, blue.
std::vector<Medium<double>> media_of(const MediumOptions& options);

/// --r lo:hi:step in mm: lo, lo + step, ... up to and including hi.
std::vector<double> parse_radii(const std::string& text);

}  // namespace opaline
