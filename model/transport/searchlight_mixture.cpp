#include "model/transport/searchlight_mixture.h"

#include "model/conventions.h"
#include "model/non_negative_least_squares.h"
#include "model/transport/asymptotic_decay.h"

#include <tbb/parallel_for.h>
#include <Eigen/Dense>

#include <cmath>

namespace opaline {
namespace {

/// exp(x) K_0(x).
double scaled_bessel_k0(double x) {
  if (x < 25) return std::cyl_bessel_k(0.0, x) * std::exp(x);
  double sum = 1, term = 1;
  for (int n = 1; n < 12; ++n) {
    term *= -(2 * n - 1.0) * (2 * n - 1.0) / (8 * n * x);
    sum += term;
  }
  return sum * std::sqrt(pi / (2 * x));
}

/// x K_1(x), 1 at x = 0.
double flux_beyond(double x) { return x == 0 ? 1 : x > 700 ? 0 : x * std::cyl_bessel_k(1.0, x); }

std::vector<double> real_wave_numbers() {
  std::vector<double> k = {0};
  for (int i = 0; i < 38; ++i) k.push_back(1e-4 * std::pow(1.5, i));
  return k;
}

/// Below 1/v0, and below 1 by enough for the rule over the rays.
std::vector<double> imaginary_wave_numbers(double decay) {
  std::vector<double> k;
  for (const double share : {0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 0.98}) k.push_back(share * std::min(decay, 0.98));
  return decay > 0 ? k : std::vector<double>{};
}

struct Sample {
  double k_squared, value, error;  ///< error: expected, relative
};

SearchlightMixture fit(double decay_squared, const std::vector<Sample>& samples) {
  constexpr int per_decade = 4, columns = 15 * per_decade + 1;
  const auto kappa_squared = [&](int j) { return decay_squared + std::pow(10.0, -9 + j / double{per_decade}); };
  const auto rows = static_cast<int>(samples.size());
  Eigen::MatrixXd a(rows, columns);
  Eigen::VectorXd b(rows);
  for (int i = 0; i < rows; ++i) {
    const Sample& s = samples[static_cast<std::size_t>(i)];
    b[i] = 1 / s.error;
    for (int j = 0; j < columns; ++j) a(i, j) = b[i] / (s.value * (s.k_squared + kappa_squared(j)));
  }
  const Eigen::VectorXd lengths = a.colwise().norm();
  const Eigen::MatrixXd scaled = a * lengths.cwiseInverse().asDiagonal();
  const Eigen::VectorXd x = non_negative_least_squares(scaled, b, 1e-16);
  SearchlightMixture mixture;
  mixture.decay = std::sqrt(decay_squared);
  mixture.residual = (scaled * x - b).cwiseAbs().maxCoeff();
  for (int j = 0; j < columns; ++j)
    if (x[j] > 0) mixture.terms.push_back({x[j] / lengths[j], std::sqrt(kappa_squared(j))});
  return mixture;
}

}  // namespace

double SearchlightMixture::log_evaluate(double r) const {
  double sum = 0;
  for (const Term& t : terms) sum += t.weight * scaled_bessel_k0(t.kappa * r) * std::exp(-(t.kappa - decay) * r);
  return std::log(sum / (2 * pi)) - decay * r;
}

double SearchlightMixture::total() const { return transform(0); }

double SearchlightMixture::flux_between(double inner, double outer) const {
  double sum = 0;
  for (const Term& t : terms)
    sum += t.weight / (t.kappa * t.kappa) * (flux_beyond(t.kappa * inner) - flux_beyond(t.kappa * outer));
  return sum;
}

double SearchlightMixture::transform(double k_squared) const {
  double sum = 0;
  for (const Term& t : terms) sum += t.weight / (k_squared + t.kappa * t.kappa);
  return sum;
}

std::vector<SearchlightMixture> searchlight_mixtures(double eta, std::span<const double> albedos, double resolution,
                                                     SearchlightExit exit) {
  const std::vector<double> real = real_wave_numbers();
  std::vector<std::vector<double>> at_real(real.size());
  tbb::parallel_for(std::size_t{0}, real.size(), [&](std::size_t i) {
    at_real[i] = searchlight_transform(real[i] * real[i], eta, albedos, resolution, exit);
  });
  std::vector<SearchlightMixture> mixtures(albedos.size());
  tbb::parallel_for(std::size_t{0}, albedos.size(), [&](std::size_t n) {
    const double decay_squared = asymptotic_decay_squared(1 - albedos[n]);
    std::vector<Sample> samples;
    for (std::size_t i = 0; i < real.size(); ++i)
      samples.push_back({real[i] * real[i], at_real[i][n], 1e-9 * (1 + std::pow(real[i], 2.5))});
    for (const double k : imaginary_wave_numbers(std::sqrt(decay_squared)))
      samples.push_back({-k * k, searchlight_transform(-k * k, eta, albedos.subspan(n, 1), resolution, exit)[0], 1e-9});
    mixtures[n] = fit(decay_squared, samples);
  });
  return mixtures;
}

}  // namespace opaline
