#include "fit/softened_profile.h"

#include "model/quadrature.h"

#include <ceres/jet.h>

#include <cmath>

namespace opaline {
namespace {

using Dual = ceres::Jet<double, 3>;

Dual to_dual(const ProfileGradient& g) {
  Dual value(g.value);
  value.v << g.d_sigma_a, g.d_sigma_s_prime, g.d_eta;
  return value;
}

ProfileGradient to_gradient(const Dual& d) { return {d.a, d.v[0], d.v[1], d.v[2]}; }

/// 2 pi int_0^r_0 R r dr with r = r_0 exp(-s), down to where the profile is flat and little is left.
Dual flux_inside(const Profile& profile, double r_0) {
  const auto ring = [&](const Dual& s) {
    const double r = r_0 * std::exp(-s.a);
    return Dual(2 * pi * r * r * to_dual(profile.evaluate_with_gradient(r)));
  };
  const double last = std::log(r_0 / profile.core_radius()) + 6;
  constexpr int panels = 3;
  Dual sum(0.0);
  for (int i = 0; i < panels; ++i) sum += gauss_legendre(Dual(last * i / panels), Dual(last * (i + 1) / panels), ring);
  return sum;
}

}  // namespace

SoftenedProfile::SoftenedProfile(const Profile& profile, double r_0)
    : profile_(profile), r_0_(r_0), softened_(profile.core_radius() < r_0) {
  if (softened_) core_ = to_gradient(flux_inside(profile, r_0));
}

ProfileGradient SoftenedProfile::evaluate_with_gradient(double r) const {
  if (!softened_) return profile_.evaluate_with_gradient(r);
  const double rho = std::hypot(r, r_0_);
  const double spread = std::exp(1 - rho / r_0_) / (2 * pi * r_0_ * rho);
  return to_gradient(to_dual(profile_.evaluate_with_gradient(rho)) + spread * to_dual(core_));
}

}  // namespace opaline
