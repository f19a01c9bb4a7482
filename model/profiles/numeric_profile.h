// Turns a templated R_d(r) without closed integrals into a Profile: total, cumulative and sampling come from a
// CumulativeTable that is made when one of them is first asked for.
//
// Formula<T> is built from a Medium<T> and has evaluate(r) and core_radius(). Dual: see formula_profile.h.
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
  explicit NumericProfile(const Medium<double>& medium)
      : formula_(medium),
        dual_(Medium<Dual>{Dual(medium.sigma_a, 0), Dual(medium.sigma_s_prime, 1), Dual(medium.eta, 2)}) {}

  double evaluate(double r) const override { return formula_.evaluate(clamped(r)); }

  ProfileGradient evaluate_with_gradient(double r) const override {
    const Dual value = dual_.evaluate(Dual(clamped(r)));
    return {value.a, value.v[0], value.v[1], value.v[2]};
  }

  /// The quadrature's error may lift a total of 1 by 1e-9.
  double total() const override { return std::min(table().total(), 1.0); }
  double cumulative(double r) const override { return std::min(table().cumulative(r), 1.0); }
  double sample(double xi) const override { return table().sample(xi); }
  double core_radius() const override { return formula_.core_radius(); }

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
  return std::make_unique<NumericProfile<Formula, Dual>>(medium);
}

}  // namespace opaline
