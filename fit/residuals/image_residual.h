// The picture's residual for one colour channel, in the reduced form of normal_equations.h.
#pragma once

#include "fit/normal_equations.h"

#include <ceres/cost_function.h>

namespace opaline {

/// (L^T x(sigma_a, sigma_s', eta) - y) / noise_sd as a Ceres cost: one residual per pivot, parameter
/// blocks ln sigma_a, ln sigma_s', eta of size 1 each. All references must outlive it.
class ImageResidual : public ceres::CostFunction {
 public:
  ImageResidual(const TransportOperator& op, const ReducedLeastSquares& reduced, const ProfileInfo& profile,
                int channel, double noise_sd);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const TransportOperator& op_;
  const ReducedLeastSquares& reduced_;
  const ProfileInfo& profile_;
  int channel_;
  double per_sd_;
};

}  // namespace opaline
