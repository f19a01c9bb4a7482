#include "model/profiles/gaussian_sum.h"

#include "model/check.h"
#include "model/non_negative_least_squares.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

double gaussian(double r, double v) { return std::exp(-r * r / (2 * v)) / (2 * pi * v); }

/// The radius that holds a share of the flux, by bisection in log r.
double radius_of_share(const Profile& profile, double share) {
  double low = std::log(1e-6 * profile.core_radius()), high = std::log(1e9 * profile.core_radius());
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (profile.cumulative(std::exp(middle)) < share * profile.total() ? low : high) = middle;
  }
  return std::exp(low);
}

std::vector<double> log_radii(double low, double high, int count) {
  std::vector<double> r;
  for (int i = 0; i < count; ++i) r.push_back(low * std::pow(high / low, (i + 0.5) / count));
  return r;
}

void measure(const Profile& profile, GaussianSum& sum) {
  const int count = 400;
  const double first = radius_of_share(profile, 1e-6), last = radius_of_share(profile, 1 - 1e-6);
  const double step = std::log(last / first) / count;
  for (const double r : log_radii(first, last, count)) {
    sum.flux_error += step * 2 * pi * r * r * std::abs(sum.evaluate(r) - profile.evaluate(r)) / profile.total();
  }
  const double inner = radius_of_share(profile, 0.01), outer = radius_of_share(profile, 0.99);
  for (const double r : log_radii(inner, outer, count)) {
    sum.worst_relative = std::max(sum.worst_relative, std::abs(sum.evaluate(r) / profile.evaluate(r) - 1));
  }
}

/// Standard deviations from low to high over sqrt(2): a Gaussian's ring density is largest at its own.
GaussianSum fit_between(const Profile& profile, int terms, double low, double high) {
  const std::vector<double> radii = log_radii(0.03 * low, 10 * high, 300);
  const int rows = static_cast<int>(radii.size());
  Eigen::MatrixXd a(rows + 1, terms);
  Eigen::VectorXd b(rows + 1);
  const double heavy = 1e4;  // the row that keeps the total
  const auto variance = [&](int k) { return 0.5 * low * low * std::pow(high / low, 2.0 * k / (terms - 1)); };
  for (int i = 0; i < rows; ++i) {
    const double r = radii[static_cast<std::size_t>(i)], ring = 2 * pi * r * r / profile.total();
    for (int k = 0; k < terms; ++k) a(i, k) = ring * gaussian(r, variance(k));
    b[i] = ring * profile.evaluate(r);
  }
  a.row(rows).setConstant(heavy / profile.total());
  b[rows] = heavy;
  const Eigen::VectorXd weights = non_negative_least_squares(a, b);
  GaussianSum sum;
  for (int k = 0; k < terms; ++k) {
    if (weights[k] > 0) sum.terms.push_back({weights[k], variance(k)});
  }
  return sum;
}

}  // namespace

double GaussianSum::evaluate(double r) const {
  double sum = 0;
  for (const Gaussian& g : terms) sum += g.weight * gaussian(r, g.variance);
  return sum;
}

double GaussianSum::total() const {
  double sum = 0;
  for (const Gaussian& g : terms) sum += g.weight;
  return sum;
}

double GaussianSum::cumulative(double r) const {
  double sum = 0;
  for (const Gaussian& g : terms) sum -= g.weight * std::expm1(-r * r / (2 * g.variance));
  return sum;
}

double GaussianSum::sample(double xi) const {
  double left = xi * total();
  for (const Gaussian& g : terms) {
    if (left < g.weight) return std::sqrt(-2 * g.variance * std::log1p(-std::min(left / g.weight, 1 - 0x1p-53)));
    left -= g.weight;
  }
  return terms.empty() ? 0 : std::sqrt(-2 * terms.back().variance * std::log(0x1p-53));
}

GaussianSum fit_gaussian_sum(const Profile& profile, int terms, double left_out) {
  if (!(profile.total() > 0)) return {};
  GaussianSum sum =
      fit_between(profile, terms, radius_of_share(profile, left_out), radius_of_share(profile, 1 - left_out));
  sum.left_out = left_out;
  return sum;
}

GaussianSum fit_gaussian_sum(const Profile& profile, int terms) {
  OPALINE_CHECK(terms >= 2 && terms <= 64);
  GaussianSum best;
  if (!(profile.total() > 0)) return best;
  for (const double left_out : {0.002, 0.01, 0.03, 0.06, 0.1, 0.15, 0.2}) {
    GaussianSum sum = fit_gaussian_sum(profile, terms, left_out);
    measure(profile, sum);
    if (best.terms.empty() || sum.flux_error < best.flux_error) best = std::move(sum);
  }
  return best;
}

}  // namespace opaline
