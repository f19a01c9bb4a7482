// Residuals in units of the noise. With precision matrices P_p (3 x 3, the inverse covariance of a pixel's channels)
// the sum of squares
//   sum_p (picture_p - t_p)^T P_p (picture_p - t_p),   picture_p,c = q_p,c . z_c,  z_c = scale L^T x_c
// is |sum_c W_c z_c - y|^2 + constant. Where P is the same for all pixels and the channels share their Q, W needs no
// sums at all: it is U (x) 1 with P = U^T U.
#pragma once

#include "fit/noise_model.h"
#include "fit/orthonormal_operator.h"

#include <array>
#include <vector>

namespace opaline {

/// One picture with its operator, reduced to what the solver needs.
struct FitTarget {
  TransportOperator op;  ///< without its values
  OrthonormalOperator basis;
  Eigen::MatrixXd picture{};                           ///< rows x channels, linear
  Eigen::MatrixXd offset{};                            ///< taken off the picture (defect_correction.h), or empty
  Eigen::MatrixXd light{};                             ///< with an offset: smooth stand-in for the picture without it
  int channels = 3;                                    ///< 1: a grey picture; only R's coefficients show
  std::array<Eigen::VectorXd, 3> y{};                  ///< Q^T t per channel
  Eigen::Matrix3d products = Eigen::Matrix3d::Zero();  ///< t_c . t_d
  NoiseModel noise{};
  bool scale_free = false;  ///< the picture's brightness is known up to a factor only

  std::size_t rows() const { return op.rows(); }
  /// The noise-free picture that its noise goes by, given the operator's.
  const Eigen::MatrixXd& noise_signal(const Eigen::MatrixXd& fitted) const {
    return offset.size() > 0 ? light : fitted;
  }
  const Eigen::MatrixXf& q(int c) const { return basis.q[static_cast<std::size_t>(op.light_channel(c))]; }
  const Eigen::MatrixXd& factor(int c) const { return basis.factor[static_cast<std::size_t>(op.light_channel(c))]; }
};

/// The upper triangle of P per pixel: rr, rg, rb, gg, gb, bb.
using PixelPrecision = std::vector<std::array<float, 6>>;

struct Whitened {
  Eigen::Matrix3d mix = Eigen::Matrix3d::Zero();  ///< U
  std::array<Eigen::Index, 3> first{};            ///< row where each channel starts, if W = U (x) 1
  std::array<Eigen::MatrixXd, 3> factor;          ///< W_c; empty: U (x) 1
  Eigen::VectorXd y;
  double constant = 0;  ///< squared residual that no z can remove, >= 0

  bool uniform() const { return factor[0].size() == 0; }
  Eigen::Index rows() const { return y.size(); }
  /// out += W_c z.
  void add(int c, const Eigen::VectorXd& z, Eigen::Ref<Eigen::VectorXd> out) const;
};

/// The same covariance for every pixel.
Whitened whiten(const FitTarget& target, const Eigen::Matrix3d& covariance);
/// Any precision per pixel.
Whitened whiten(const FitTarget& target, const PixelPrecision& precision);

/// Variance of a pixel's noise, never below that of a signal of a thousandth of the picture's RMS: noise that vanishes
/// with the signal would give single black pixels all the weight.
double pixel_variance(const FitTarget& target, const NoiseModel& noise, int c, double signal);

/// P of every pixel for a noise where the noise-free picture is `signal` (rows x channels).
PixelPrecision pixel_precision(const FitTarget& target, const NoiseModel& noise, const Eigen::MatrixXd& signal);

}  // namespace opaline
