#include "fit/noise_weights.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// Correlation of residuals over their known sizes, cut at 3 so that outliers don't make it.
Eigen::Matrix3d residual_correlation(const FitTarget& target, const Eigen::MatrixXd& fitted) {
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();
  const Eigen::MatrixXd& signal = target.noise_signal(fitted);
  for (Eigen::Index p = 0; p < signal.rows(); ++p) {
    Eigen::Vector3d r = Eigen::Vector3d::Zero();
    for (int c = 0; c < target.channels; ++c)
      r[c] = std::clamp(
          (target.picture(p, c) - fitted(p, c)) / std::sqrt(pixel_variance(target, target.noise, c, signal(p, c))),
          -3.0, 3.0);
    sums += r * r.transpose();
  }
  for (int c = target.channels; c < 3; ++c) sums(c, c) = 1;
  const Eigen::Vector3d per_sd = sums.diagonal().cwiseMax(1e-30).cwiseSqrt().cwiseInverse();
  return regular_covariance(per_sd.asDiagonal() * sums * per_sd.asDiagonal());
}

double channel_rms(const FitTarget& target, int c) {
  return std::sqrt(std::max(target.products(c, c), 1e-25) / static_cast<double>(target.rows()));
}

/// Of a channel that is black beside the others (what does not scatter) the least noise, else 0: no picture is as dark
/// as that within the coefficients' bounds, and what is left would count for more than all the other channels.
double least_noise(const FitTarget& target, int c) {
  constexpr double black = 1e-6, allowed = 1e-3;
  const double brightest = std::sqrt(target.products.diagonal().maxCoeff() / static_cast<double>(target.rows()));
  return channel_rms(target, c) < black * brightest ? allowed * brightest : 0;
}

Covariance known_covariance(const FitTarget& target, const NoiseModel& noise, const Eigen::MatrixXd& signal) {
  Eigen::Vector3d sd = Eigen::Vector3d::Ones();
  for (int c = 0; c < target.channels; ++c) {
    double sum = 0;
    for (Eigen::Index p = 0; p < signal.rows(); ++p) sum += pixel_variance(target, noise, c, signal(p, c));
    sd[c] = std::sqrt(sum / static_cast<double>(signal.rows()));
  }
  return sd.asDiagonal() * noise.correlation * sd.asDiagonal();
}

/// Sums of products of the channels' residuals over the pixels.
Eigen::Matrix3d residual_products(const FitTarget& target, const std::array<ReducedChannel, 3>& picture, double scale) {
  Eigen::Matrix3d sums = Eigen::Matrix3d::Zero();
  for (int c = 0; c < target.channels; ++c)
    for (int d = 0; d < target.channels; ++d) {
      if (c != d && (target.op.light_channels > 1 || target.noise.correlation_known)) continue;
      const auto i = static_cast<std::size_t>(c), j = static_cast<std::size_t>(d);
      const Eigen::VectorXd& y_c = target.y[i];
      const Eigen::VectorXd& y_d = target.y[j];
      double outside = target.products(c, d) - y_c.dot(y_d);
      if (c == d) outside = std::max(outside, 0.0);
      sums(c, d) = (scale * picture[i].value - y_c).dot(scale * picture[j].value - y_d) + outside;
    }
  return sums;
}

Covariance residual_covariance(const FitProblem& problem, const FitPoint& at, std::size_t t) {
  const FitTarget& target = problem.targets()[t];
  const auto picture = reduced_picture(target, problem.profile(), to_material(at.material, {}), false);
  const Eigen::Matrix3d sums = residual_products(target, picture, std::exp(at.ln_scale[t]));
  int channels = 0;
  for (const FitTarget& other : problem.targets()) channels += other.channels;
  const double rows = static_cast<double>(target.rows());
  const double freedom = std::max(1.0, rows - static_cast<double>(free_count(problem)) / channels);
  Covariance covariance = Covariance::Identity();
  for (int c = 0; c < target.channels; ++c)
    for (int d = 0; d < target.channels; ++d) covariance(c, d) = sums(c, d) / freedom;
  for (int c = 0; c < target.channels; ++c) {
    const double floor = std::max({1e-12 * channel_rms(target, c), 1e-15, least_noise(target, c)});
    covariance(c, c) = std::max(covariance(c, c), floor * floor);
  }
  return regular_covariance(covariance);
}

}  // namespace

NoiseModel completed_noise(const FitTarget& target, const Eigen::MatrixXd& fitted) {
  NoiseModel noise = target.noise;
  if (noise.known && !noise.correlation_known) noise.correlation = residual_correlation(target, fitted);
  return noise;
}

int free_count(const FitProblem& problem) {
  int count = 0;
  for (int i = 0; i < parameter_count; ++i) count += problem.is_free(i);
  for (const FitTarget& target : problem.targets()) count += target.scale_free;
  return count;
}

Eigen::MatrixXd fitted_rows(const FitProblem& problem, const FitPoint& at, std::size_t t) {
  return std::exp(at.ln_scale[t]) * target_rows(problem.targets()[t], problem.profile(), to_material(at.material, {}));
}

std::vector<Whitened> first_weights(const std::vector<FitTarget>& targets) {
  std::vector<Whitened> weights;
  for (const FitTarget& target : targets) {
    if (target.noise.known) {
      const Eigen::MatrixXd& signal = target.noise_signal(target.picture);
      weights.push_back(target.noise.uniform() ? whiten(target, known_covariance(target, target.noise, signal))
                                               : whiten(target, pixel_precision(target, target.noise, signal)));
      continue;
    }
    Covariance covariance = Covariance::Identity();
    for (int c = 0; c < target.channels; ++c)
      covariance(c, c) = std::pow(std::max(1e-2 * channel_rms(target, c), least_noise(target, c)), 2);
    weights.push_back(whiten(target, covariance));
  }
  return weights;
}

std::vector<Covariance> noise_at(const FitProblem& problem, const FitPoint& at) {
  std::vector<Covariance> all;
  for (std::size_t t = 0; t < problem.targets().size(); ++t) {
    const FitTarget& target = problem.targets()[t];
    if (!target.noise.known) {
      all.push_back(residual_covariance(problem, at, t));
      continue;
    }
    const Eigen::MatrixXd fitted = fitted_rows(problem, at, t);
    all.push_back(known_covariance(target, completed_noise(target, fitted), target.noise_signal(fitted)));
  }
  return all;
}

std::vector<Whitened> weights_at(const FitProblem& problem, const FitPoint& at) {
  std::vector<Whitened> weights;
  for (std::size_t t = 0; t < problem.targets().size(); ++t) {
    const FitTarget& target = problem.targets()[t];
    if (!target.noise.known) {
      weights.push_back(whiten(target, residual_covariance(problem, at, t)));
      continue;
    }
    const Eigen::MatrixXd fitted = fitted_rows(problem, at, t), signal = target.noise_signal(fitted);
    const NoiseModel noise = completed_noise(target, fitted);
    weights.push_back(noise.uniform() ? whiten(target, known_covariance(target, noise, signal))
                                      : whiten(target, pixel_precision(target, noise, signal)));
  }
  return weights;
}

FixedWeights::FixedWeights(const FitProblem& problem, const FitPoint& at) : covariance_(noise_at(problem, at)) {
  for (std::size_t t = 0; t < problem.targets().size(); ++t) {
    const FitTarget& target = problem.targets()[t];
    const bool even = !target.noise.known || target.noise.uniform();
    const Eigen::MatrixXd fitted = fitted_rows(problem, at, t);
    precision_.push_back(even ? PixelPrecision()
                              : pixel_precision(target, completed_noise(target, fitted), target.noise_signal(fitted)));
  }
}

std::vector<Whitened> FixedWeights::whiten(const std::vector<FitTarget>& targets) const {
  std::vector<Whitened> all;
  for (std::size_t t = 0; t < targets.size(); ++t)
    all.push_back(precision_[t].empty() ? opaline::whiten(targets[t], covariance_[t])
                                        : opaline::whiten(targets[t], precision_[t]));
  return all;
}

}  // namespace opaline
