// What the pictures determine, in words.
#pragma once

#include "fit/uncertainty.h"

#include <string>
#include <vector>

namespace opaline {

/// A quantity that the coefficients make, and how well the fit knows it.
struct Derived {
  std::string name;  ///< "sigma_t'", "sigma_tr", "alpha'"
  double value = 0;  ///< [1/mm], or a share
  double relative_sd = 0;
};

struct ChannelDiagnosis {
  std::vector<Derived> quantities;
  std::string sentence;  ///< which of them the data determine
};

struct Diagnosis {
  std::vector<ChannelDiagnosis> channels;  ///< R, G, B, or one of a grey fit
  bool determined = true;                  ///< every free parameter is
  std::string refusal;                     ///< why there is no number, and what to add; empty if determined
};

/// First-order propagation from the covariance: sigma_t' = sigma_a + sigma_s', sigma_tr = sqrt(3 sigma_a sigma_t'),
/// alpha' = sigma_s'/sigma_t'.
Diagnosis diagnose(const Solution& solution, const Uncertainty& u);

}  // namespace opaline
