// Turns a templated formula into a Profile: values in double, gradients by dual numbers.
//
// Formula<T> is built from a Medium<T> and has evaluate(r), total(), cumulative(r), sample(xi) and
// core_radius(), as StandardDipole; plane_spectrum(k, z) where there is a closed one. Dual is ceres::Jet<double, 3>; it
// is a parameter so that only a profile's .cpp includes Ceres.
#pragma once

#include "model/profiles/profile.h"

#include <algorithm>

namespace opaline {

template <template <typename> class Formula, typename Dual>
class FormulaProfile final : public Profile {
 public:
  explicit FormulaProfile(const Medium<double>& medium)
      : formula_(medium),
        dual_(Medium<Dual>{Dual(medium.sigma_a, 0), Dual(medium.sigma_s_prime, 1), Dual(medium.eta, 2)}),
        total_(formula_.total()) {}

  double evaluate(double r) const override { return formula_.evaluate(clamped(r)); }

  ProfileGradient evaluate_with_gradient(double r) const override {
    const Dual value = dual_.evaluate(Dual(clamped(r)));
    return {value.a, value.v[0], value.v[1], value.v[2]};
  }

  double total() const override { return total_; }
  double cumulative(double r) const override { return std::min(formula_.cumulative(clamped(r)), total_); }
  double sample(double xi) const override { return formula_.sample(xi); }
  double core_radius() const override { return formula_.core_radius(); }
  std::optional<double> plane_spectrum([[maybe_unused]] double k, [[maybe_unused]] double z) const override {
    if constexpr (requires { formula_.plane_spectrum(k, z); })
      return formula_.plane_spectrum(k, z);
    else
      return std::nullopt;
  }

 private:
  /// Beyond this r^2 overflows; every profile is 0 there.
  static double clamped(double r) { return std::min(r, 1e150); }

  Formula<double> formula_;
  Formula<Dual> dual_;
  double total_;
};

/// The `build` of a registry row without parameters.
template <template <typename> class Formula, typename Dual>
std::unique_ptr<Profile> make_formula_profile(const Medium<double>& medium, const ProfileParameters&) {
  return std::make_unique<FormulaProfile<Formula, Dual>>(medium);
}

}  // namespace opaline
