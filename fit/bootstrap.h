// Refits of what the picture would have been with other noise: how the whole procedure errs, not its linearisation.
#pragma once

#include "fit/fit_problem.h"

namespace opaline {

struct Bootstrap {
  /// Repetitions x columns of Solution::jacobian: the solver's parameters (ln sigma, eta, ln scales).
  Eigen::MatrixXd draws;
  int failed = 0;             ///< repetitions that did not converge; they are not among the draws
  Eigen::VectorXd sd;         ///< of the solver's parameters; 0 where fixed
  Eigen::VectorXd bias;       ///< mean of the draws minus the solution
  Eigen::VectorXd low, high;  ///< 2.5 % and 97.5 % of the draws
  double seconds = 0;
};

/// Parametric: data drawn from the model at the solution with the noise that weights it. In the whitened coordinates
/// of Q that is one unit normal per residual, exactly the noise of all pixels seen by the fit, so a repetition costs a
/// few solver steps and no pixel. Numbered by `seed`: the same for any number of threads.
/// sensitivity: of the operator's parameters to the reference's (defect_correction.h), or empty: draws are the
/// reference's, its inverse times what the operator's move.
Bootstrap bootstrap(const FitProblem& problem, const Solution& solution, int repetitions, std::uint64_t seed,
                    const Eigen::MatrixXd& sensitivity = {});

}  // namespace opaline
