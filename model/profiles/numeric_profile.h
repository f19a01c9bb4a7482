// Turns a templated R_d(r) without a closed inverse into a Profile: sampling, and the total and the cumulative unless
// the formula has them, come from a CumulativeTable that is made when one of them is first asked for.
//
// Formula<T> has evaluate(r) and core_radius(), and may have total(), cumulative(r), transmittance(r) and
// total_transmittance(). Dual: see formula_profile.h.
#pragma once

#include "model/profiles/cumulative_table.h"
#include "model/profiles/profile.h"

#include <algorithm>
#include <mutex>
#include <optional>

namespace opaline {

template <template <typename> class Formula, typename Dual>
class NumericProfile final : public Profile {
 public:
  /// The same formula, for values and with derivatives by sigma_a, sigma_s' and eta.
  NumericProfile(Formula<double> formula, Formula<Dual> dual) : formula_(std::move(formula)), dual_(std::move(dual)) {}

  double evaluate(double r) const override { return formula_.evaluate(clamped(r)); }

  ProfileGradient evaluate_with_gradient(double r) const override {
    const Dual value = dual_.evaluate(Dual(clamped(r)));
    return {value.a, value.v[0], value.v[1], value.v[2]};
  }

  double total() const override {
    if constexpr (requires(const Formula<double>& f) { f.total(); }) {
      return formula_.total();
    } else {
      return table().total();
    }
  }
  double cumulative(double r) const override {
    if constexpr (requires(const Formula<double>& f) { f.cumulative(r); }) {
      return std::min(formula_.cumulative(clamped(r)), formula_.total());
    } else {
      return std::min(table().cumulative(r), total());
    }
  }
  double sample(double xi) const override { return table().sample(xi); }
  double core_radius() const override { return formula_.core_radius(); }
  double transmittance(double r) const override {
    if constexpr (requires(const Formula<double>& f) { f.transmittance(r); }) {
      return formula_.transmittance(clamped(r));
    } else {
      return 0;
    }
  }
  double total_transmittance() const override {
    if constexpr (requires(const Formula<double>& f) { f.total_transmittance(); }) {
      return formula_.total_transmittance();
    } else {
      return 0;
    }
  }

 private:
  /// Beyond this r^2 overflows; every profile is 0 there.
  static double clamped(double r) { return std::min(r, 1e150); }

  const CumulativeTable& table() const {
    std::call_once(made_, [&] {
      table_.emplace([&](double r) { return formula_.evaluate(clamped(r)); }, formula_.core_radius());
    });
    return *table_;
  }

  Formula<double> formula_;
  Formula<Dual> dual_;
  mutable std::once_flag made_;
  mutable std::optional<CumulativeTable> table_;
};

/// The `build` of a registry row without parameters.
template <template <typename> class Formula, typename Dual>
std::unique_ptr<Profile> make_numeric_profile(const Medium<double>& medium, const ProfileParameters&) {
  const Medium<Dual> dual{Dual(medium.sigma_a, 0), Dual(medium.sigma_s_prime, 1), Dual(medium.eta, 2)};
  return std::make_unique<NumericProfile<Formula, Dual>>(Formula<double>(medium), Formula<Dual>(dual));
}

}  // namespace opaline
