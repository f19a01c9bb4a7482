#include "fit/whitening.h"

#include "fit/pivoted_cholesky.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <algorithm>

namespace opaline {
namespace {

using Eigen::Index;

/// The block of channels that the picture has.
Eigen::MatrixXd used(const Eigen::Matrix3d& m, int channels) { return m.topLeftCorner(channels, channels); }

Eigen::Matrix3d embedded(const Eigen::MatrixXd& m) {
  Eigen::Matrix3d out = Eigen::Matrix3d::Zero();
  out.topLeftCorner(m.rows(), m.cols()) = m;
  return out;
}

/// Place of (c, d), c <= d, in PixelPrecision.
constexpr std::size_t place[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};

bool all_zero(const PixelPrecision& precision, std::size_t at) {
  return std::all_of(precision.begin(), precision.end(), [at](const auto& p) { return p[at] == 0; });
}

std::vector<float> entries(const PixelPrecision& precision, std::size_t at) {
  std::vector<float> values(precision.size());
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = precision[i][at];
  return values;
}

/// Channels whose Q differ, or that share noise across different Q, need the sums.
bool sums_needed(const FitTarget& target, const Eigen::Matrix3d& precision) {
  return target.op.light_channels > 1 && !precision.isDiagonal(1e-12);
}

PixelPrecision constant_precision(const Eigen::Matrix3d& p, std::size_t rows) {
  std::array<float, 6> upper;
  for (int c = 0; c < 3; ++c)
    for (int d = c; d < 3; ++d) upper[place[c][d]] = static_cast<float>(p(c, d));
  return PixelPrecision(rows, upper);
}

}  // namespace

Eigen::Matrix3d regular_covariance(const Eigen::Matrix3d& covariance, double least) {
  const Eigen::Vector3d sd = covariance.diagonal().cwiseMax(1e-300).cwiseSqrt();
  const Eigen::Matrix3d correlation = sd.cwiseInverse().asDiagonal() * covariance * sd.cwiseInverse().asDiagonal();
  const double smallest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(correlation).eigenvalues()[0];
  const double keep = smallest >= least ? 1 : (1 - least) / (1 - std::min(smallest, 0.0));
  Eigen::Matrix3d regular = keep * correlation + (1 - keep) * Eigen::Matrix3d::Identity();
  return sd.asDiagonal() * regular * sd.asDiagonal();
}

void Whitened::add(int c, const Eigen::VectorXd& z, Eigen::Ref<Eigen::VectorXd> out) const {
  if (!uniform()) {
    out += factor[static_cast<std::size_t>(c)] * z;
    return;
  }
  for (int d = 0; d <= c; ++d)
    if (mix(d, c) != 0) out.segment(first[static_cast<std::size_t>(d)], z.size()) += mix(d, c) * z;
}

Whitened whiten(const FitTarget& target, const Eigen::Matrix3d& covariance) {
  const Eigen::MatrixXd precision = used(covariance, target.channels).inverse();
  if (sums_needed(target, embedded(precision)))
    return whiten(target, constant_precision(embedded(precision), target.rows()));
  Whitened out;
  out.mix = embedded(Eigen::LLT<Eigen::MatrixXd>(precision).matrixU());
  Index rows = 0;
  for (int c = 0; c < target.channels; ++c) {
    out.first[static_cast<std::size_t>(c)] = rows;
    rows += target.y[static_cast<std::size_t>(c)].size();
  }
  out.y = Eigen::VectorXd::Zero(rows);
  double total = 0;
  for (int c = 0; c < target.channels; ++c) {
    out.add(c, target.y[static_cast<std::size_t>(c)], out.y);
    for (int d = 0; d < target.channels; ++d) total += embedded(precision)(c, d) * target.products(c, d);
  }
  out.constant = std::max(0.0, total - out.y.squaredNorm());
  return out;
}

Whitened whiten(const FitTarget& target, const PixelPrecision& precision) {
  std::array<Index, 4> at{};
  for (int c = 0; c < 3; ++c)
    at[static_cast<std::size_t>(c) + 1] =
        at[static_cast<std::size_t>(c)] + (c < target.channels ? target.y[static_cast<std::size_t>(c)].size() : 0);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(at[3], at[3]);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(at[3]);
  double tau = 0;
  for (int c = 0; c < target.channels; ++c)
    for (int d = c; d < target.channels; ++d) {
      if (all_zero(precision, place[c][d])) continue;
      const std::vector<float> p = entries(precision, place[c][d]);
      const Eigen::VectorXd weight =
          Eigen::Map<const Eigen::VectorXf>(p.data(), static_cast<Index>(p.size())).cast<double>();
      const Index i = at[static_cast<std::size_t>(c)], j = at[static_cast<std::size_t>(d)];
      const Eigen::MatrixXf &q_c = target.q(c), &q_d = target.q(d);
      const Eigen::MatrixXd block = weighted_gram(q_c, q_d, p.data());
      gram.block(i, j, block.rows(), block.cols()) = block;
      if (c != d) gram.block(j, i, block.cols(), block.rows()) = block.transpose();
      const Eigen::VectorXd w_c = weight.cwiseProduct(target.picture.col(c)),
                            w_d = weight.cwiseProduct(target.picture.col(d));
      b.segment(i, q_c.rows()) += basis_sum(q_c, w_d);
      if (c != d) b.segment(j, q_d.rows()) += basis_sum(q_d, w_c);
      tau += (c == d ? 1 : 2) * w_c.dot(target.picture.col(d));
    }
  const PivotedCholesky cholesky = pivoted_cholesky(gram, 1e-13);
  const Eigen::MatrixXd factor = cholesky.factor_transposed();
  Whitened out;
  for (int c = 0; c < target.channels; ++c)
    out.factor[static_cast<std::size_t>(c)] = factor.middleCols(
        at[static_cast<std::size_t>(c)], at[static_cast<std::size_t>(c) + 1] - at[static_cast<std::size_t>(c)]);
  out.y = cholesky.solve(b);
  out.constant = std::max(0.0, tau - out.y.squaredNorm());
  return out;
}

double pixel_variance(const FitTarget& target, const NoiseModel& noise, int c, double signal) {
  constexpr double darkest_share = 1e-3;
  const double darkest = darkest_share * std::sqrt(target.products(c, c) / static_cast<double>(target.rows()));
  return std::max(noise.variance(c, std::max(signal, darkest)), 1e-30);
}

PixelPrecision pixel_precision(const FitTarget& target, const NoiseModel& noise, const Eigen::MatrixXd& signal) {
  PixelPrecision precision(target.rows());
  const Eigen::MatrixXd inverse = used(noise.correlation, target.channels).inverse();
  for (std::size_t p = 0; p < precision.size(); ++p) {
    precision[p] = {};
    Eigen::Vector3d sd;
    for (int c = 0; c < target.channels; ++c)
      sd[c] = std::sqrt(pixel_variance(target, noise, c, signal(static_cast<Index>(p), c)));
    for (int c = 0; c < target.channels; ++c)
      for (int d = c; d < target.channels; ++d)
        precision[p][place[c][d]] = static_cast<float>(inverse(c, d) / (sd[c] * sd[d]));
  }
  return precision;
}

}  // namespace opaline
