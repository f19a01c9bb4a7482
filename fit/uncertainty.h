// What the data say about each parameter: covariance, intervals, correlations, identifiability.
#pragma once

#include "fit/solve.h"

#include <array>
#include <string>
#include <vector>

namespace opaline {

struct ParameterEstimate {
  double value = 0;  ///< 1/mm, or eta
  double sd = 0;     ///< of the value (first order); 1e6 of ln sigma or eta when nothing is known
  /// 95 % interval, within the bounds; from ln for coefficients. Holds the ends of all starts that fit as well.
  double low = 0, high = 0;
  bool free = true;
  bool identifiable = true;           ///< the interval is narrower than a factor of 2 and off the bounds
  std::string reason;                 ///< why not, in words
  std::string interval = "parabola";  ///< how it was found: parabola, profile (profile_interval.h)
};

struct Uncertainty {
  std::array<ParameterEstimate, parameter_count> parameters;
  std::array<ParameterEstimate, 3> alpha_prime;  ///< derived: sigma_s' / (sigma_a + sigma_s')
  Eigen::MatrixXd covariance;      ///< of the solver's parameters (ln sigma, eta, then ln scales); 0 for fixed ones
  Eigen::MatrixXd correlation;     ///< of the same, unit diagonal
  double condition = 1;            ///< of the Jacobian with unit columns
  std::vector<double> scale_sd;    ///< of the ln scales that are free, in the order of their targets
  std::vector<std::string> notes;  ///< trade-offs a reader must know, in words
};

/// Intervals that changed are widened to the ends of starts that fit as well, and judged anew.
void include_starts_and_judge(const Solution& solution, Uncertainty& u);

/// (J^T J)^-1 of the whitened Jacobian; directions the data do not determine get a large variance
/// instead of being dropped.
Uncertainty uncertainty(const Solution& solution, const FreeParameters& free);

}  // namespace opaline
