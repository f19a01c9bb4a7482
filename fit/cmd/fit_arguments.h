// The options of `opaline fit` and what they mean for a job.
#pragma once

#include "fit/fit_job.h"

#include <CLI/CLI.hpp>

#include <string>
#include <vector>

namespace opaline {

struct FitArguments {
  FitJob job;
  std::string free = "sigma_a,sigma_s_prime,eta", exit = "auto", scale = "known", loss = "squares", out, truth,
              reference;
  std::vector<std::string> priors, exports, reference_settings;
  double saturation = -1;
  int threads = 0;
  bool json = false, parabola = false, allow_undetermined = false;
};

/// Declares the options; `a` must outlive the command.
void add_fit_options(CLI::App& fit, FitArguments& a);

/// Turns words into a.job. Throws InputError or std::invalid_argument naming the option and the valid choices.
void complete(FitArguments& a);

}  // namespace opaline
