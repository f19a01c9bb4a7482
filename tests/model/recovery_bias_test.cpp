// What fits of diffusion profiles to perfect transport data return: small residuals, wrong coefficients. The profile of
// transport stands for the data (its own error is below 4e-4); log residuals at 40 radii, eta known, absolute scale.
#include "model/profiles/profile.h"

#include <gtest/gtest.h>

#include <cmath>

namespace opaline {
namespace {

struct Bias {
  double sigma_a, sigma_s_prime, rms;  ///< percent, percent, of the log residual
};

/// Residuals ln(model/truth) at radii from `near` to `far` transport mean free paths.
std::vector<double> residuals(const ProfileInfo& model, double ln_a, double ln_s, const std::vector<double>& truth,
                              const std::vector<double>& radii, double eta) {
  const auto profile = model.make({std::exp(ln_a), std::exp(ln_s), eta});
  std::vector<double> r;
  for (std::size_t i = 0; i < radii.size(); ++i) r.push_back(std::log(profile->evaluate(radii[i]) / truth[i]));
  return r;
}

double cost(const std::vector<double>& r) {
  double sum = 0;
  for (const double v : r) sum += v * v;
  return std::isfinite(sum) ? sum : HUGE_VAL;
}

/// Damped Gauss-Newton in (ln sigma_a, ln sigma_s').
Bias fit(const std::string& name, double alpha_prime, double eta, double near, double far) {
  const ProfileInfo& model = *find_profile(name);
  std::vector<double> radii, truth;
  const auto transport = find_profile("transport_table")->make({1 - alpha_prime, alpha_prime, eta});
  for (int i = 0; i < 40; ++i) {
    radii.push_back(near * std::pow(far / near, i / 39.0));
    truth.push_back(transport->evaluate(radii.back()));
  }
  double a = std::log(1 - alpha_prime), s = std::log(alpha_prime), damping = 1e-3;
  std::vector<double> r = residuals(model, a, s, truth, radii, eta);
  for (int step = 0; step < 200; ++step) {
    const double h = 1e-5;
    const auto up_a = residuals(model, a + h, s, truth, radii, eta),
               up_s = residuals(model, a, s + h, truth, radii, eta);
    double aa = 0, as = 0, ss = 0, ga = 0, gs = 0;
    for (std::size_t i = 0; i < r.size(); ++i) {
      const double ja = (up_a[i] - r[i]) / h, js = (up_s[i] - r[i]) / h;
      aa += ja * ja, as += ja * js, ss += js * js, ga += ja * r[i], gs += js * r[i];
    }
    aa *= 1 + damping, ss *= 1 + damping;
    const double det = aa * ss - as * as, da = -(ss * ga - as * gs) / det, ds = -(aa * gs - as * ga) / det;
    const auto next = residuals(model, a + da, s + ds, truth, radii, eta);
    if (cost(next) < cost(r)) {
      a += da, s += ds, r = next, damping = std::max(damping / 10, 1e-9);
      if (std::hypot(da, ds) < 1e-9) break;
    } else {
      damping *= 10;
    }
  }
  return {100 * (std::exp(a) / (1 - alpha_prime) - 1), 100 * (std::exp(s) / alpha_prime - 1),
          std::sqrt(cost(r) / static_cast<double>(r.size()))};
}

struct Row {
  const char* model;
  double alpha_prime, eta, near, far, sigma_a, sigma_s_prime, rms;
  double tolerance;  ///< percent
};

/// Found elsewhere from Monte-Carlo walks, printed to whole percents. The spacing of its radii isn't known, and the
/// worse a model fits the more it matters: with even spacing instead of logarithmic the standard dipole at alpha' .8
/// moves from +20 and -47 % to +11 and -36 %, the others by at most 5, the better dipole by at most 3.
constexpr Row table[] = {
    {"standard_dipole", 0.8, 1.3, 2, 20, 24, -59, 0.07, 13},    {"better_dipole", 0.8, 1.3, 2, 20, 13, -17, 0.003, 3},
    {"standard_dipole", 0.9, 1.3, 2, 20, 5, -16, 0.07, 5},      {"better_dipole", 0.9, 1.3, 2, 20, 17, -17, 0.001, 3},
    {"standard_dipole", 0.95, 1.3, 2, 20, -1.5, -3.6, 0.04, 5}, {"better_dipole", 0.95, 1.3, 2, 20, 25, -19, 0.007, 3},
    {"standard_dipole", 0.99, 1.3, 2, 20, -8, 6, 0.024, 5},     {"better_dipole", 0.99, 1.3, 2, 20, 63, -25, 0.028, 3},
    {"standard_dipole", 0.99, 1.5, 2, 20, -49, 49, 0.04, 5},    {"better_dipole", 0.99, 1.5, 2, 20, 30, -14, 0.015, 3},
};

TEST(RecoveryBias, OfTheDipolesIsThatOfMonteCarloData) {
  for (const Row& row : table) {
    const Bias b = fit(row.model, row.alpha_prime, row.eta, row.near, row.far);
    SCOPED_TRACE(std::string(row.model) + " " + std::to_string(row.alpha_prime) + " " + std::to_string(row.eta));
    EXPECT_NEAR(b.sigma_a, row.sigma_a, row.tolerance);
    EXPECT_NEAR(b.sigma_s_prime, row.sigma_s_prime, row.tolerance);
    EXPECT_LT(b.rms, 1.8 * row.rms + 0.005);
  }
}

TEST(RecoveryBias, TransportReturnsItself) {
  const Bias b = fit("transport_table", 0.99, 1.3, 2, 20);
  EXPECT_NEAR(b.sigma_a, 0, 1e-4);
  EXPECT_NEAR(b.sigma_s_prime, 0, 1e-4);
}

}  // namespace
}  // namespace opaline
