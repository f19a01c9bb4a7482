#include "fit/reduced_picture.h"

#include <tbb/parallel_for.h>

#include <optional>

namespace opaline {
namespace {

using Eigen::Index;

/// sum_k f_k L_k^T: rank x radial nodes.
Eigen::MatrixXd contract(const Eigen::MatrixXd& factor, const std::vector<double>& f, Index radial) {
  Eigen::MatrixXd sum = f[0] * factor.leftCols(radial);
  for (std::size_t k = 1; k < f.size(); ++k) sum += f[k] * factor.middleCols(static_cast<Index>(k) * radial, radial);
  return sum;
}

/// L^T with the eta nodes summed up.
struct Contracted {
  Eigen::MatrixXd value, d_eta;

  Contracted(const FitTarget& target, double eta, int channel, bool derivatives) {
    const EtaFactors f = eta_factors(target.op, eta);
    value = contract(target.factor(channel), f.value, target.op.radial.size());
    if (derivatives) d_eta = contract(target.factor(channel), f.d_eta, target.op.radial.size());
  }
};

Eigen::VectorXd column(const std::vector<ProfileGradient>& radial, double ProfileGradient::*member) {
  Eigen::VectorXd v(static_cast<Index>(radial.size()));
  for (std::size_t n = 0; n < radial.size(); ++n) v[static_cast<Index>(n)] = radial[n].*member;
  return v;
}

}  // namespace

std::array<ReducedChannel, 3> reduced_picture(const FitTarget& target, const ProfileInfo& profile,
                                              const Material& material, bool derivatives) {
  std::array<ReducedChannel, 3> out;
  std::optional<Contracted> nodes;
  for (int c = 0; c < target.channels; ++c) {
    const double colour = target.op.light_colour(c);
    if (!nodes || target.op.light_channels > 1) nodes.emplace(target, material.eta, c, derivatives);
    const std::vector<ProfileGradient> radial = radial_coefficients(target.op, profile, material.channel(c));
    ReducedChannel& r = out[static_cast<std::size_t>(c)];
    const Eigen::VectorXd value = column(radial, &ProfileGradient::value);
    r.value = colour * (nodes->value * value);
    if (!derivatives) continue;
    r.d_sigma_a = colour * (nodes->value * column(radial, &ProfileGradient::d_sigma_a));
    r.d_sigma_s_prime = colour * (nodes->value * column(radial, &ProfileGradient::d_sigma_s_prime));
    r.d_eta = colour * (nodes->value * column(radial, &ProfileGradient::d_eta) + nodes->d_eta * value);
  }
  return out;
}

Eigen::MatrixXd target_rows(const FitTarget& target, const ProfileInfo& profile, const Material& material) {
  const std::array<ReducedChannel, 3> z = reduced_picture(target, profile, material, false);
  const auto rows = static_cast<Index>(target.rows());
  Eigen::MatrixXd out(rows, target.channels);
  constexpr Index piece = 1024;
  for (int c = 0; c < target.channels; ++c) {
    const Eigen::VectorXd& value = z[static_cast<std::size_t>(c)].value;
    tbb::parallel_for(Index{0}, (rows + piece - 1) / piece, [&](Index i) {
      const Index first = i * piece, count = std::min(piece, rows - first);
      out.col(c).segment(first, count) = target.q(c).middleCols(first, count).cast<double>().transpose() * value;
    });
  }
  return out;
}

Image target_image(const FitTarget& target, const ProfileInfo& profile, const Material& material, double scale) {
  Image image(target.op.width, target.op.height, {"R", "G", "B", "A"});
  const Eigen::MatrixXd rows = target_rows(target, profile, material);
  for (std::size_t p = 0; p < target.rows(); ++p) {
    float* pixel = &image.data[target.op.pixels[p] * 4u];
    for (int c = 0; c < 3; ++c)
      pixel[c] = static_cast<float>(scale * rows(static_cast<Index>(p), std::min(c, target.channels - 1)));
    pixel[3] = 1;
  }
  return image;
}

}  // namespace opaline
