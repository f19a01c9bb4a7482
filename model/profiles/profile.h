// The contract of a diffusion profile R_d(r), and the registry of all of them.
//
// A profile is one templated formula in one .cpp of this folder plus one line in CMakeLists.txt. Its row states what it
// needs beyond a medium (parameters), what holds for it (monotone, conserves_energy, ...) and where it may be used
// (domain). Normalisation, units: see conventions.h (R_d in 1/mm^2, per transmitted flux).
#pragma once

#include "model/conventions.h"
#include "model/profiles/parameters.h"

#include <memory>
#include <optional>
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
  /// 2 pi int_0^inf R_d r dr: total diffuse reflectance, >= 0; at most 1 if the registry says conserves_energy.
  virtual double total() const = 0;
  /// 2 pi int_0^r R_d s ds, <= total().
  virtual double cumulative(double r) const = 0;
  /// Radius with density 2 pi r R_d(r) / total() for xi in [0, 1); finite.
  virtual double sample(double xi) const = 0;
  /// The radius below which R_d is flat: the shortest length a quadrature must resolve [mm].
  virtual double core_radius() const = 0;

  /// The 2-D Fourier transform int R_d(sqrt(r^2 + z^2)) J_0(k r) 2 pi r dr of what a plane sends to a parallel one z
  /// [mm] away, k [1/mm] and z >= 0, in closed form; nothing where the formula has none. total() at k = z = 0.
  virtual std::optional<double> plane_spectrum(double /*k*/, double /*z*/) const { return std::nullopt; }

  /// Diffuse transmittance T(r) [1/mm^2] on the far side and its integral; 0 unless the registry says
  /// has_transmittance.
  virtual double transmittance(double) const { return 0; }
  virtual double total_transmittance() const { return 0; }
};

/// Where a profile may be used, as data.
struct ProfileDomain {
  double eta_min, eta_max;
  double alpha_prime_min;        ///< smallest reduced albedo at which the formula is meant to hold
  double thickness_min_mfp = 0;  ///< smallest thickness of a layer, in its transport mean free paths 1/sigma_t'
  std::string note;
};

struct ProfileInfo {
  std::string name;
  std::string citation;
  ProfileDomain domain;
  bool monotone;  ///< R_d is positive and non-increasing in r
  /// From a medium and a completed set of parameters; callers use make().
  std::unique_ptr<Profile> (*build)(const Medium<double>& medium, const ProfileParameters& completed);
  std::vector<ProfileParameter> parameters = {};
  bool conserves_energy = true;       ///< total() <= 1
  bool depends_on_direction = false;  ///< the model knows the direction of incidence; the row is for a normal beam
  bool radiance = false;              ///< along the normal, as an exitance, in place of exitance: transport_radiance.h
  bool depends_on_medium = true;
  bool has_transmittance = false;
  double gradient_error = 0;  ///< relative; 0: dual numbers, exact to rounding

  /// The profile of a medium. Throws ProfileParameterError for a parameter that is unknown, missing or not valid.
  std::unique_ptr<Profile> make(const Medium<double>& medium, const ProfileParameters& given = {}) const;
  /// `given` checked, with the fallbacks of the others.
  ProfileParameters complete(const ProfileParameters& given) const;
  /// Whether every parameter has a fallback: make(medium) works.
  bool needs_medium_alone() const;
  /// Why the medium or a layer lies outside the domain, a sentence each; empty inside. For warnings: make() works
  /// there too.
  std::vector<std::string> outside_domain(const Medium<double>& medium, const ProfileParameters& given = {}) const;
};

/// All registered profiles, in the order of CMakeLists.txt.
const std::vector<ProfileInfo>& profiles();

/// The profile of that name, or nullptr.
const ProfileInfo* find_profile(const std::string& name);

/// Names of all profiles, or of those that need a medium alone.
std::vector<std::string> profile_names();
std::vector<std::string> medium_profile_names();

}  // namespace opaline
