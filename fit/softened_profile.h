// A profile as the radial basis can see it. The basis takes profiles to be flat below r_0 and smooth in r^2 + r_0^2
// (radial_basis.h); one whose core is narrower, such as transport's own 1/r, would be sampled at its peak. It is
// spread over r_0 instead, its flux kept: with rho = sqrt(r^2 + r_0^2),
//   R(rho) + flux(r < r_0) exp(1 - rho/r_0)/(2 pi r_0 rho)
// in place of R(r), which differs by (r_0/r)^2 beyond a few r_0.
#pragma once

#include "model/profiles/profile.h"

namespace opaline {

class SoftenedProfile {
 public:
  /// Nothing changes for a profile with core_radius() >= r_0.
  SoftenedProfile(const Profile& profile, double r_0);

  ProfileGradient evaluate_with_gradient(double r) const;

 private:
  const Profile& profile_;
  double r_0_;
  bool softened_;
  ProfileGradient core_{};  ///< flux inside r_0 and its derivatives
};

}  // namespace opaline
