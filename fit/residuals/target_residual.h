// One target's residual in units of its noise, as a Ceres cost.
#pragma once

#include "fit/reduced_picture.h"

#include <ceres/sized_cost_function.h>

namespace opaline {

/// sum_c W_c exp(ln scale) z_c - y (whitening.h). Parameter blocks of size 1: the seven of parameters.h and ln scale.
/// y: the data, whitened's own or another's. All references must outlive it.
class TargetResidual : public ceres::CostFunction {
 public:
  TargetResidual(const FitTarget& target, const Whitened& whitened, const Eigen::VectorXd& y,
                 const ProfileInfo& profile);
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const FitTarget& target_;
  const Whitened& whitened_;
  const Eigen::VectorXd& y_;
  const ProfileInfo& profile_;
};

/// (p - mean) / sd of one of the solver's parameters.
class PriorResidual : public ceres::SizedCostFunction<1, 1> {
 public:
  PriorResidual(double mean, double sd) : mean_(mean), sd_(sd) {}
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    residuals[0] = (parameters[0][0] - mean_) / sd_;
    if (jacobians && jacobians[0]) jacobians[0][0] = 1 / sd_;
    return true;
  }

 private:
  double mean_, sd_;
};

}  // namespace opaline
