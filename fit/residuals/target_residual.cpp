#include "fit/residuals/target_residual.h"

#include <cmath>

namespace opaline {

TargetResidual::TargetResidual(const FitTarget& target, const Whitened& whitened, const Eigen::VectorXd& y,
                               const ProfileInfo& profile)
    : target_(target), whitened_(whitened), y_(y), profile_(profile) {
  set_num_residuals(static_cast<int>(whitened.rows()));
  mutable_parameter_block_sizes()->assign(parameter_count + 1, 1);
}

bool TargetResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  ParameterVector p;
  for (std::size_t i = 0; i < parameter_count; ++i) p[i] = parameters[i][0];
  const double scale = std::exp(parameters[parameter_count][0]);
  const Material material = to_material(p, {});
  const std::array<ReducedChannel, 3> picture = reduced_picture(target_, profile_, material, jacobians != nullptr);
  const auto n = static_cast<Eigen::Index>(num_residuals());
  const auto whitened = [&](double* out, int c, double factor, const Eigen::VectorXd& z) {
    if (out) whitened_.add(c, factor * z, Eigen::Map<Eigen::VectorXd>(out, n));
  };
  Eigen::Map<Eigen::VectorXd> r(residuals, n);
  r = -y_;
  for (int i = 0; jacobians && i <= parameter_count; ++i)
    if (jacobians[i]) Eigen::Map<Eigen::VectorXd>(jacobians[i], n).setZero();
  for (int c = 0; c < target_.channels; ++c) {
    const ReducedChannel& z = picture[static_cast<std::size_t>(c)];
    whitened(residuals, c, scale, z.value);
    if (!jacobians) continue;
    whitened(jacobians[c], c, scale * material.sigma_a[c], z.d_sigma_a);
    whitened(jacobians[c + 3], c, scale * material.sigma_s_prime[c], z.d_sigma_s_prime);
    whitened(jacobians[eta_index], c, scale, z.d_eta);
    whitened(jacobians[parameter_count], c, scale, z.value);
  }
  return true;
}

}  // namespace opaline
