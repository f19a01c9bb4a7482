// Every profile fitted to the same operator: which of them explain the picture, and which of those agree on what it is
// made of. A small residual is no accuracy: diffusion profiles fit transport to 1 % with coefficients tens of percent
// off.
#pragma once

#include "fit/uncertainty.h"

#include <string>
#include <vector>

namespace opaline {

struct ModelFit {
  std::string name;
  std::string same_as;  ///< another row whose values it has, exactly; not fitted again, and nothing below is filled
  Solution solution;
  Uncertainty uncertainty;
  double bic = 0;        ///< Bayesian information criterion: -2 ln L + k ln n, up to a constant of the data
  double delta_bic = 0;  ///< above the best model's; more than 10 is decisive
};

struct ModelComparison {
  std::vector<ModelFit> models;       ///< in the registry's order
  std::vector<std::string> left_out;  ///< profiles that could not be compared, each with the reason
  std::vector<std::string> warnings;  ///< in words
  double seconds = 0;
};

/// Fits every isotropic profile that needs a medium alone, from the solution of `chosen` and `starts` more points.
ModelComparison compare_models(const std::vector<FitTarget>& targets, const std::string& chosen,
                               const Solution& solution, const Uncertainty& uncertainty, const Material& material,
                               const SolveSettings& settings, int starts = 2);

}  // namespace opaline
