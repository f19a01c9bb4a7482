#include "fit/robust.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Per target: residual rows over the noise's square root, P^(1/2) r.
struct WhitePixels {
  std::vector<Eigen::Matrix3d> root;  ///< upper U with P = U^T U
  MatrixXd residual;                  ///< rows x channels, U r
  std::vector<double> length;         ///< of a row over root channels
};

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Standard deviations from medians of |r|, correlations from residuals cut at three of them.
Covariance bulk_covariance(const FitTarget& target, const MatrixXd& r) {
  Eigen::Vector3d sd = Eigen::Vector3d::Ones();
  for (int c = 0; c < target.channels; ++c) {
    std::vector<double> sizes(static_cast<std::size_t>(r.rows()));
    for (Index p = 0; p < r.rows(); ++p) sizes[static_cast<std::size_t>(p)] = std::abs(r(p, c));
    sd[c] = std::max(1.482602218505602 * median(std::move(sizes)), 1e-15);
  }
  Eigen::Matrix3d products = Eigen::Matrix3d::Identity();
  for (int c = 0; c < target.channels; ++c)
    for (int d = 0; d < target.channels && !target.noise.correlation_known; ++d) {
      double sum = 0;
      for (Index p = 0; p < r.rows(); ++p)
        sum += std::clamp(r(p, c) / sd[c], -3.0, 3.0) * std::clamp(r(p, d) / sd[d], -3.0, 3.0);
      products(c, d) = sum / static_cast<double>(r.rows());
    }
  const Eigen::Vector3d own = products.diagonal().cwiseSqrt().cwiseInverse();
  return regular_covariance(sd.asDiagonal() * (own.asDiagonal() * products * own.asDiagonal()) * sd.asDiagonal());
}

WhitePixels whiten_pixels(const FitTarget& target, const MatrixXd& fitted, const MatrixXd& r,
                          const Covariance& covariance) {
  WhitePixels out{{}, MatrixXd(r.rows(), r.cols()), {}};
  const NoiseModel noise = completed_noise(target, fitted);
  const MatrixXd& signal = target.noise_signal(fitted);
  const int n = target.channels;
  for (Index p = 0; p < r.rows(); ++p) {
    MatrixXd local = covariance.topLeftCorner(n, n);
    if (noise.known) {
      for (int c = 0; c < n; ++c)
        for (int d = 0; d < n; ++d)
          local(c, d) = noise.correlation(c, d) * std::sqrt(pixel_variance(target, noise, c, signal(p, c)) *
                                                            pixel_variance(target, noise, d, signal(p, d)));
    }
    Eigen::Matrix3d root = Eigen::Matrix3d::Zero();
    root.topLeftCorner(n, n) = Eigen::LLT<MatrixXd>(local.inverse()).matrixU();
    out.root.push_back(root);
    out.residual.row(p) = (root.topLeftCorner(n, n) * r.row(p).transpose()).transpose();
    out.length.push_back(out.residual.row(p).norm() / std::sqrt(static_cast<double>(n)));
  }
  return out;
}

PixelPrecision weighted_precision(const WhitePixels& white, const RobustLoss& loss, double& mean) {
  PixelPrecision precision;
  mean = 0;
  for (std::size_t p = 0; p < white.length.size(); ++p) {
    const double w = loss.weight(white.length[p]);
    const Eigen::Matrix3d full = w * white.root[p].transpose() * white.root[p];
    precision.push_back({static_cast<float>(full(0, 0)), static_cast<float>(full(0, 1)), static_cast<float>(full(0, 2)),
                         static_cast<float>(full(1, 1)), static_cast<float>(full(1, 2)),
                         static_cast<float>(full(2, 2))});
    mean += w / static_cast<double>(white.length.size());
  }
  return precision;
}

/// d picture / d parameter of pixel p: channels x columns.
MatrixXd pixel_jacobian(const FitTarget& target, const std::array<ReducedChannel, 3>& z, const Material& m,
                        double scale, int scale_at, Index p, Index columns) {
  MatrixXd j = MatrixXd::Zero(target.channels, columns);
  for (int c = 0; c < target.channels; ++c) {
    const Eigen::VectorXd q = target.q(c).col(p).cast<double>();
    const ReducedChannel& r = z[static_cast<std::size_t>(c)];
    j(c, c) = scale * m.sigma_a[c] * q.dot(r.d_sigma_a);
    j(c, c + 3) = scale * m.sigma_s_prime[c] * q.dot(r.d_sigma_s_prime);
    j(c, eta_index) = scale * q.dot(r.d_eta);
    if (scale_at >= 0) j(c, scale_at) = scale * q.dot(r.value);
  }
  return j;
}

/// Curvature H and spread B of the estimating equations.
void add_sandwich(const FitProblem& problem, const FitPoint& at, std::size_t t, const WhitePixels& white, MatrixXd& h,
                  MatrixXd& b) {
  const FitTarget& target = problem.targets()[t];
  const RobustLoss& loss = problem.settings().loss;
  const Material m = to_material(at.material, {});
  const auto z = reduced_picture(target, problem.profile(), m, true);
  const int scale_at = scale_column(problem.targets(), t);
  const int n = target.channels;
  for (Index p = 0; p < white.residual.rows(); ++p) {
    const double d = white.length[static_cast<std::size_t>(p)], w = loss.weight(d);
    const MatrixXd j = white.root[static_cast<std::size_t>(p)].topLeftCorner(n, n) *
                       pixel_jacobian(target, z, m, std::exp(at.ln_scale[t]), scale_at, p, h.cols());
    const Eigen::VectorXd along = j.transpose() * white.residual.row(p).transpose();
    h += w * j.transpose() * j;
    if (d > 0) h += loss.slope(d) / (d * n) * along * along.transpose();
    b += w * w * along * along.transpose();
  }
}

/// U of the sandwich over the free columns.
MatrixXd effective_jacobian(const FitProblem& problem, MatrixXd h, MatrixXd b) {
  for (const Prior& prior : problem.settings().priors) {
    h(prior.parameter, prior.parameter) += 1 / (prior.sd * prior.sd);
    b(prior.parameter, prior.parameter) += 1 / (prior.sd * prior.sd);
  }
  std::vector<Index> free;
  for (Index i = 0; i < h.cols(); ++i)
    if (i >= parameter_count || problem.is_free(static_cast<int>(i))) free.push_back(i);
  const auto k = static_cast<Index>(free.size());
  MatrixXd h_free(k, k), b_free(k, k);
  for (Index i = 0; i < k; ++i)
    for (Index j = 0; j < k; ++j) {
      h_free(i, j) = h(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(j)]);
      b_free(i, j) = b(free[static_cast<std::size_t>(i)], free[static_cast<std::size_t>(j)]);
    }
  // (H^-1 B H^-1)^-1 = H B^-1 H.
  const MatrixXd ridge = 1e-12 * b_free.diagonal().asDiagonal().toDenseMatrix() + 1e-30 * MatrixXd::Identity(k, k);
  const MatrixXd information = h_free * (b_free + ridge).ldlt().solve(h_free);
  const MatrixXd upper = Eigen::LLT<MatrixXd>(0.5 * (information + information.transpose())).matrixU();
  MatrixXd out = MatrixXd::Zero(k, h.cols());
  for (Index i = 0; i < k; ++i) out.col(free[static_cast<std::size_t>(i)]) = upper.col(i);
  return out;
}

double change(const FitPoint& a, const FitPoint& b) {
  double most = 0;
  for (std::size_t i = 0; i < parameter_count; ++i) most = std::max(most, std::abs(a.material[i] - b.material[i]));
  for (std::size_t t = 0; t < a.ln_scale.size(); ++t) most = std::max(most, std::abs(a.ln_scale[t] - b.ln_scale[t]));
  return most;
}

}  // namespace

double RobustLoss::weight(double d) const {
  constexpr double k = 1.345, c = 2.385;
  if (kind == Kind::huber) return d <= k ? 1 : k / d;
  if (kind == Kind::cauchy) return 1 / (1 + d * d / (c * c));
  return 1;
}

double RobustLoss::slope(double d) const {
  constexpr double k = 1.345, c = 2.385;
  if (kind == Kind::huber) return d <= k ? 0 : -k / (d * d);
  if (kind == Kind::cauchy) return -2 * d / (c * c) * weight(d) * weight(d);
  return 0;
}

RobustFit robust_fit(const std::vector<FitTarget>& targets, const ProfileInfo& profile, const SolveSettings& settings,
                     const ParameterBounds& bounds, const FitPoint& from) {
  RobustFit out;
  out.end.at = from;
  out.whitened.resize(targets.size());
  out.noise.assign(targets.size(), Covariance::Identity());
  out.mean_weight.assign(targets.size(), 1);
  std::vector<WhitePixels> white(targets.size());
  const FitProblem problem(targets, out.whitened, profile, settings, bounds);
  const auto weigh = [&](const FitPoint& at) {
    for (std::size_t t = 0; t < targets.size(); ++t) {
      const MatrixXd fitted = fitted_rows(problem, at, t), r = fitted - targets[t].picture;
      if (!targets[t].noise.known) out.noise[t] = bulk_covariance(targets[t], r);
      white[t] = whiten_pixels(targets[t], fitted, r, out.noise[t]);
      out.whitened[t] = whiten(targets[t], weighted_precision(white[t], settings.loss, out.mean_weight[t]));
    }
  };
  // Weights of squares go by the signal alone, which hardly moves from here.
  const bool squares = settings.loss.kind == RobustLoss::Kind::squares;
  const int most_rounds = squares ? 1 : 40;
  for (int round = 0; round < most_rounds && !out.settled; ++round) {
    weigh(out.end.at);
    const FitEnd next = problem.minimise(out.end.at);
    out.settled = squares ? next.converged : change(next.at, out.end.at) < 1e-7;
    const std::vector<double> history = out.end.history;
    out.end = next;
    out.end.history.insert(out.end.history.begin(), history.begin(), history.end());
  }
  weigh(out.end.at);
  const Index columns = problem.jacobian(out.end.at).cols();
  MatrixXd h = MatrixXd::Zero(columns, columns), b = h;
  for (std::size_t t = 0; t < targets.size(); ++t) add_sandwich(problem, out.end.at, t, white[t], h, b);
  out.jacobian = effective_jacobian(problem, h, b);
  for (std::size_t t = 0; t < targets.size(); ++t)
    if (targets[t].noise.known) out.noise[t] = noise_at(problem, out.end.at)[t];
  return out;
}

}  // namespace opaline
