// Least squares over all targets with deterministic multi-start.
#pragma once

#include "fit/parameters.h"
#include "fit/whitening.h"

#include <Eigen/Core>

#include <string>
#include <vector>

namespace opaline {

/// Throws InputError unless the picture has the film's size and the channels R, G, B (or one alone: grey). Cheap:
/// called before the operator is gathered.
void check_target(const Image& target, const Scene& scene, const std::string& name);

/// Reduces the target; the operator's values are released. Throws InputError if a value on a fitted pixel is not finite
/// or no pixel takes part. `name` is for messages.
FitTarget make_target(TransportOperator op, const Image& target, const std::string& name, const NoiseModel& noise = {});

/// Gives `target` another picture of the same rows (rows x channels): what a repetition with new noise needs.
void replace_picture(FitTarget& target, Eigen::MatrixXd picture);

/// How residuals far outside the noise count. The residual of a pixel is its length d over the channels in units of the
/// noise, divided by the root of the number of channels.
struct RobustLoss {
  enum class Kind { squares, huber, cauchy } kind = Kind::squares;
  /// Weight of a pixel's squared residual: 1; min(1, k/d) with k = 1.345; 1/(1 + (d/c)^2) with c = 2.385 (95 %
  /// efficient for one channel of normal noise).
  double weight(double d) const;
  double slope(double d) const;  ///< dw/dd
};

struct SolveSettings {
  FreeParameters free;
  ParameterBounds bounds;
  std::vector<Prior> priors;
  RobustLoss loss;
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
  std::vector<double> history{};   ///< cost after each iteration
  std::vector<double> ln_scale{};  ///< per target at `to`
};

struct Solution {
  ParameterVector parameters{};
  std::vector<double> ln_scale;     ///< per target; 0 where it is known
  ParameterBounds bounds;           ///< searched: the settings', within what every operator resolves
  std::vector<StartRecord> starts;  ///< in start order; the first is the scene's own material
  int best_start = 0;
  int iterations = 0;  ///< over all starts
  bool converged = false;
  std::vector<std::array<double, 3>> noise_sd;  ///< per target and channel: RMS of the noise residuals are weighted by
  std::vector<Eigen::Matrix3d> noise_correlation;  ///< per target, between channels
  double rmse = 0, relative_rmse = 0;              ///< over all targets, pixels and channels
  double chi_squared = 0, freedom = 0;             ///< whitened squares; values minus free parameters
  double minus_two_ln_likelihood = 0;              ///< of normal noise, up to a constant of the data alone
  /// Whitened, rows x (7 + one per target of free scale); columns of fixed parameters are 0. The priors' rows come
  /// last.
  Eigen::MatrixXd jacobian;
  Eigen::Index prior_rows = 0;
  bool grey = false;                       ///< one channel was fitted; G and B repeat it
  std::vector<Whitened> whitened;          ///< the targets as weighted at the end
  std::vector<double> pixel_weight_share;  ///< robust losses: mean weight of a pixel, per target
  double seconds = 0;
};

/// Does any target's noise leave its intervals to the residuals?
bool rough_noise(const std::vector<FitTarget>& targets);

/// A mean free path below an operator's r_0 is flatter in it than in the picture, so that its fit would be an
/// artefact: coefficients above 1/r_0 are not searched, whatever the settings allow.
/// initial: the material to start from; its values stay where a parameter is not free.
/// A grey picture has one channel: G and B follow R.
Solution solve(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const Material& initial,
               const SolveSettings& settings);

}  // namespace opaline
