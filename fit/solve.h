// Least squares over all targets with deterministic multi-start.
#pragma once

#include "fit/normal_equations.h"
#include "fit/parameters.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace opaline {

/// One picture with its operator, reduced to what the solver needs.
struct FitTarget {
  TransportOperator op;
  std::vector<ReducedLeastSquares> reduced;  ///< per light channel
  std::array<double, 3> tau{};               ///< sum of squares of the target per colour
  const ReducedLeastSquares& of(int channel) const {
    return reduced[static_cast<std::size_t>(op.light_channel(channel))];
  }
};

/// Throws InputError unless the picture has the film's size and the channels R, G, B. Cheap: called
/// before the operator is gathered.
void check_target(const Image& target, const Scene& scene, const std::string& name);

/// Reduces the target. Throws InputError if a value on a fitted pixel is not finite or no pixel takes
/// part. `name` is for messages.
FitTarget make_target(TransportOperator op, const Image& target, const std::string& name);

struct SolveSettings {
  FreeParameters free;
  ParameterBounds bounds;
  int starts = 8;
  std::uint64_t seed = 1;
  int max_iterations = 200;
};

struct StartRecord {
  ParameterVector from{}, to{};
  double cost = 0;    ///< half the sum of squared whitened residuals
  double excess = 0;  ///< of `to` over the solution, in half chi-squared: below 2 the data cannot tell them apart
  bool converged = false;
  std::string message{};
  std::vector<double> history{};  ///< cost after each iteration
};

struct Solution {
  ParameterVector parameters{};
  ParameterBounds bounds;           ///< searched: the settings', within what every operator resolves
  std::vector<StartRecord> starts;  ///< in start order; the first is the scene's own material
  int best_start = 0;
  int iterations = 0;  ///< over all starts
  bool converged = false;
  std::vector<std::array<double, 3>> noise_sd;  ///< per target and channel, from the residuals
  double rmse = 0, relative_rmse = 0;           ///< over all targets, pixels and channels
  Eigen::MatrixXd jacobian;                     ///< whitened, rows x 7; columns of fixed parameters are 0
  double seconds = 0;
};

/// A mean free path below an operator's r_0 is flatter in it than in the picture, so that its fit would be an
/// artefact: coefficients above 1/r_0 are not searched, whatever the settings allow.
/// initial: the material to start from; its values stay where a parameter is not free.
Solution solve(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
               const SolveSettings& settings);

}  // namespace opaline
