#include "render/irradiance/profile_bounds.h"

#include "model/check.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace opaline {
namespace {

constexpr int samples = 4;    ///< of each row
constexpr double fine = 256;  ///< x over the step of the differences
constexpr double margin = 1.05, table_margin = 1.5, tiny = 1e-37;

/// A profile as a function of q, with bounds of its derivatives there.
struct SquaredProfile {
  const Profile& profile;
  double core_squared;

  double operator()(double q) const { return profile.evaluate(std::sqrt(std::max(q, 0.0))); }

  /// |f^(k)| at a place no farther than k h left of q; near the axis extrapolated from the right.
  double derivative(double q, int k) const {
    const double h = (q + core_squared) / fine;
    if (q >= k * h) return difference(q - k * h, h, k);
    const double at = k * core_squared / fine, here = difference(q, h, k), next = difference(q + at, h, k);
    return next > 0 ? here * std::max(1.0, here / next) : here;
  }

 private:
  /// |k-th difference over q, q + h, .. q + k h| / h^k.
  double difference(double q, double h, int k) const {
    double sum = 0, binomial = 1;
    for (int j = 0; j <= k; ++j) {
      sum += (j % 2 ? -binomial : binomial) * (*this)(q + j * h);
      binomial *= static_cast<double>(k - j) / (j + 1);
    }
    return std::abs(sum) / std::pow(h, k);
  }
};

/// What the kernel makes of a point at distance r, one value per table.
std::array<float, 3> kernel_values(const ProfileSum& tables, double r) {
  PatchList point(1);
  point.push_point(glm::vec3(0), 1);
  point.pad();
  std::array<float, 3> sums{};
  add_profile_sum(tables, point, nullptr, {static_cast<float>(r), 0, 0}, sums.data());
  return sums;
}

struct RowMaker {
  const ProfileSum& tables;
  double core_squared, r_max, position_error;

  /// Lifts a row over what lies between q = lo and hi.
  void raise(ProfileBounds::Row& row, std::span<const Profile* const> profiles, double lo, double hi) const {
    const double step = (hi - lo) / samples;
    for (int s = 0; s < samples; ++s) {
      const double q = lo + s * step, inside = std::min(q, r_max * r_max);
      const std::array<float, 3> kernel = kernel_values(tables, std::sqrt(inside));
      for (std::size_t o = 0; o < profiles.size(); ++o)
        raise(row, o, {*profiles[o], core_squared}, q, step, kernel[o] - profiles[o]->evaluate(std::sqrt(inside)));
    }
  }

 private:
  void raise(ProfileBounds::Row& row, std::size_t o, const SquaredProfile& f, double q, double step,
             double table_error) const {
    const auto lift = [o](ProfileBounds::Four& bound, double value) {
      bound[o] = std::max(bound[o], static_cast<float>(value + tiny));
    };
    const double x = q + step + core_squared, slope = margin * f.derivative(q, 1);
    lift(row.first, x * slope);
    lift(row.second, margin * x * x * f.derivative(q, 2));
    lift(row.third, margin * x * x * x * f.derivative(q, 3) / 6);
    lift(row.fourth, margin * x * x * x * x * f.derivative(q, 4) / 24);
    lift(row.high, f(q) * (1 + 1e-6));
    const double moved = 2 * std::sqrt(q + step) * position_error + position_error * position_error + 4e-7 * (q + step);
    lift(row.noise, table_margin * std::abs(table_error) + slope * moved);
  }
};

}  // namespace

double ProfileBounds::edge(std::size_t row) const {
  const float x = std::bit_cast<float>((first_ + static_cast<std::int32_t>(row)) << shift);
  return static_cast<double>(std::max(0.0f, x - core_squared_));
}

ProfileBounds::ProfileBounds(std::span<const Profile* const> profiles, const ProfileSum& tables, double core,
                             double r_max, double position_error)
    : outputs_(static_cast<int>(profiles.size())), core_squared_(static_cast<float>(core * core)) {
  OPALINE_CHECK(outputs_ >= 1 && outputs_ <= 3 && core_squared_ > 0 && r_max > 0);
  first_ = std::bit_cast<std::int32_t>(core_squared_) >> shift;
  const float x_max = static_cast<float>(1.1 * r_max * r_max) + core_squared_;
  rows_.assign(static_cast<std::size_t>((std::bit_cast<std::int32_t>(x_max) >> shift) - first_) + 1, Row{});
  const RowMaker maker{tables, static_cast<double>(core_squared_), r_max, position_error};
  // From the right: each row starts with the suprema of those beyond it.
  for (std::size_t i = rows_.size(); i-- > 0;) {
    if (i + 1 < rows_.size()) rows_[i] = rows_[i + 1];
    maker.raise(rows_[i], profiles, edge(i), edge(i + 1));
  }
  for (std::size_t i = 0; i < rows_.size(); ++i)
    for (std::size_t o = 0; o < profiles.size(); ++o) {
      const auto here = static_cast<float>(profiles[o]->evaluate(std::sqrt(edge(i + 1))) * (1 - 1e-6));
      rows_[i].low[o] = i ? std::min(rows_[i - 1].low[o], here) : here;
    }
}

ProfileBounds ProfileBounds::per_channel(const int table_of[3]) const {
  ProfileBounds channels = *this;
  channels.outputs_ = 3;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    for (const auto field : {&Row::first, &Row::second, &Row::third, &Row::fourth, &Row::high, &Row::low, &Row::noise})
      for (std::size_t c = 0; c < 3; ++c)
        (channels.rows_[i].*field)[c] = (rows_[i].*field)[static_cast<std::size_t>(table_of[c])];
  return channels;
}

}  // namespace opaline
