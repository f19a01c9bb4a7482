// The weights of a fit: from what is known of the noise, or from the residual that a first fit left.
#pragma once

#include "fit/fit_problem.h"
#include "fit/reduced_picture.h"

namespace opaline {

/// Covariance of a target's channels.
using Covariance = Eigen::Matrix3d;

/// Before anything is known: a hundredth of each channel's RMS, so that channels count alike; known noise as it is,
/// with the picture standing for the signal.
std::vector<Whitened> first_weights(const std::vector<FitTarget>& targets);

/// Covariance of the noise that residuals at `at` show, per target, with degrees of freedom counted; correlations where
/// the noise model asks for them and the channels see the same light. Of a known noise: its mean over the pixels.
std::vector<Covariance> noise_at(const FitProblem& problem, const FitPoint& at);

/// Weights by that: equal over the pixels, or with the signal `at` predicts where noise depends on it.
std::vector<Whitened> weights_at(const FitProblem& problem, const FitPoint& at);

/// Rows of the picture at `at`, with its scale: rows x channels.
Eigen::MatrixXd fitted_rows(const FitProblem& problem, const FitPoint& at, std::size_t target);

/// The target's noise where its picture is fitted by `fitted`, with its correlation filled in from the residual if the
/// model leaves that open.
NoiseModel completed_noise(const FitTarget& target, const Eigen::MatrixXd& fitted);

/// How pixels are weighted at one place, kept while others are compared with it.
class FixedWeights {
 public:
  FixedWeights(const FitProblem& problem, const FitPoint& at);
  /// Of the same targets with other pictures.
  std::vector<Whitened> whiten(const std::vector<FitTarget>& targets) const;

 private:
  std::vector<Covariance> covariance_;
  std::vector<PixelPrecision> precision_;  ///< empty: the same for every pixel
};

/// Number of free parameters, free scales included.
int free_count(const FitProblem& problem);

}  // namespace opaline
