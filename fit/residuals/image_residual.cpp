#include "fit/residuals/image_residual.h"

#include <cmath>

namespace opaline {

ImageResidual::ImageResidual(const TransportOperator& op, const ReducedLeastSquares& reduced,
                             const ProfileInfo& profile, int channel, double noise_sd)
    : op_(op), reduced_(reduced), profile_(profile), channel_(channel), per_sd_(1 / noise_sd) {
  set_num_residuals(static_cast<int>(reduced.factor_transposed.rows()));
  *mutable_parameter_block_sizes() = {1, 1, 1};
}

bool ImageResidual::Evaluate(double const* const* parameters, double* residuals, double** jacobians) const {
  const Medium<double> medium{std::exp(parameters[0][0]), std::exp(parameters[1][0]), parameters[2][0]};
  const ColumnCoefficients x = column_coefficients(op_, profile_, medium, channel_);
  const auto vector = [](const std::vector<double>& v) {
    return Eigen::Map<const Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size()));
  };
  const auto n = static_cast<Eigen::Index>(num_residuals());
  const Eigen::MatrixXd& factor = reduced_.factor_transposed;
  Eigen::Map<Eigen::VectorXd>(residuals, n) =
      per_sd_ * (factor * vector(x.value) - reduced_.y[static_cast<std::size_t>(channel_)]);
  if (!jacobians) return true;
  const auto fill = [&](int block, const std::vector<double>& derivative, double chain) {
    if (jacobians[block])
      Eigen::Map<Eigen::VectorXd>(jacobians[block], n) = (per_sd_ * chain) * (factor * vector(derivative));
  };
  fill(0, x.d_sigma_a, medium.sigma_a);
  fill(1, x.d_sigma_s_prime, medium.sigma_s_prime);
  fill(2, x.d_eta, 1);
  return true;
}

}  // namespace opaline
