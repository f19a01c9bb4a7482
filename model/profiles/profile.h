// The contract of a diffusion profile R_d(r), and the registry of all of them.
//
// A profile is one templated formula in one .cpp of this folder plus one line in CMakeLists.txt.
// Normalisation, units: see conventions.h (R_d in 1/mm^2, per transmitted flux).
#pragma once

#include "model/conventions.h"

#include <memory>
#include <string>
#include <vector>

namespace opaline {

/// R_d(r) and its partial derivatives with respect to the medium's three parameters.
struct ProfileGradient {
  double value;            ///< [1/mm^2]
  double d_sigma_a;        ///< [1/mm]
  double d_sigma_s_prime;  ///< [1/mm]
  double d_eta;            ///< [1/mm^2]
};

/// A profile with the coefficients of one medium (one colour channel) worked out.
class Profile {
 public:
  virtual ~Profile() = default;
  /// R_d at distance r [mm], r >= 0; finite, >= 0, non-increasing in r if the registry says monotone.
  virtual double evaluate(double r) const = 0;
  virtual ProfileGradient evaluate_with_gradient(double r) const = 0;
  /// 2 pi int_0^inf R_d r dr: total diffuse reflectance, in [0, 1].
  virtual double total() const = 0;
  /// 2 pi int_0^r R_d s ds, <= total().
  virtual double cumulative(double r) const = 0;
  /// Radius with density 2 pi r R_d(r) / total() for xi in [0, 1); finite.
  virtual double sample(double xi) const = 0;
  /// The radius below which R_d is flat: the shortest length a quadrature must resolve [mm].
  virtual double core_radius() const = 0;
};

/// Where a profile may be used, as data.
struct ProfileDomain {
  double eta_min, eta_max;
  double alpha_prime_min;  ///< smallest reduced albedo at which the formula is meant to hold
  std::string note;
};

struct ProfileInfo {
  std::string name;
  std::string citation;
  ProfileDomain domain;
  bool monotone;  ///< R_d is positive and non-increasing in r
  std::unique_ptr<Profile> (*make)(const Medium<double>& medium);
};

/// All registered profiles, in the order of CMakeLists.txt.
const std::vector<ProfileInfo>& profiles();

/// The profile of that name, or nullptr.
const ProfileInfo* find_profile(const std::string& name);

}  // namespace opaline
