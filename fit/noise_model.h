// What the fit knows of the noise in a picture: nothing (then its residual tells one size per channel), or its size as
// a camera's,
//   variance = read^2 + shot * signal + (relative * signal)^2   per channel, in the picture's linear units
// (the last term is a renderer's, whose paths differ in what they bring; of cameras it is small), and how much of it
// the colour channels share: as given (not at all, unless told), or as the residual shows. The latter is for noise:
// what a model cannot explain is shared by the channels too, and would be taken for it. Estimates of it from pictures:
// noise_estimate.h.
#pragma once

#include <Eigen/Core>

#include <array>
#include <string>

namespace opaline {

struct NoiseModel {
  bool known = false;                                         ///< false: one size per channel, from the residual
  std::array<double, 3> read_sd{};                            ///< [picture]
  std::array<double, 3> shot{};                               ///< [picture]: variance per unit of signal
  std::array<double, 3> relative{};                           ///< sd as a share of the signal
  Eigen::Matrix3d correlation = Eigen::Matrix3d::Identity();  ///< between channels of one pixel
  bool correlation_known = true;                              ///< false: the residual tells the correlation
  /// Sizes good enough for weights, but not the whole of the noise: intervals come from how the residuals scatter (the
  /// sandwich, as for robust losses).
  bool rough = false;
  std::string source = "the residual";  ///< where it comes from, for reports

  bool uniform() const { return shot == std::array<double, 3>{} && relative == std::array<double, 3>{}; }
  /// Of a channel whose noise-free value is `signal`.
  double variance(int c, double signal) const {
    const auto i = static_cast<std::size_t>(c);
    const double s = signal > 0 ? signal : 0;
    return read_sd[i] * read_sd[i] + shot[i] * s + relative[i] * relative[i] * s * s;
  }
};

/// A correlation matrix kept at a distance from singular: eigenvalues of `covariance`'s correlation at least `least`.
Eigen::Matrix3d regular_covariance(const Eigen::Matrix3d& covariance, double least = 0.02);

}  // namespace opaline
