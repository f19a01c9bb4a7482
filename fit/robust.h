// Residuals far outside the noise count less: an M-estimate by iteratively reweighted least squares.
#pragma once

#include "fit/noise_weights.h"

namespace opaline {

struct RobustFit {
  FitEnd end;
  std::vector<Whitened> whitened;
  std::vector<Covariance> noise;    ///< of the bulk of the pixels: from medians, where it isn't known
  std::vector<double> mean_weight;  ///< of a pixel, per target
  /// Upper triangle U with U^T U = (H^-1 B H^-1)^-1, in the columns of Solution::jacobian: the sandwich covariance,
  /// which holds whatever the noise's distribution is.
  Eigen::MatrixXd jacobian;
  bool settled = false;  ///< weights and parameters stopped changing
};

/// From the least-squares solution `from`.
RobustFit robust_fit(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const SolveSettings& settings,
                     const ParameterBounds& bounds, const FitPoint& from);

}  // namespace opaline
