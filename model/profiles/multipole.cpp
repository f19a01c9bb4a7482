#include "model/profiles/multipole.h"

#include "model/profiles/formula_profile.h"
#include "model/profiles/numeric_profile.h"
#include "model/profiles/standard_dipole.h"

#include <ceres/jet.h>

namespace opaline {
namespace {

using Dual = ceres::Jet<double, 3>;

/// As a row wants it: 0 where the model fails and turns negative.
template <typename T>
struct SlabProfile {
  Multipole<T> multipole;

  T evaluate(const T& r) const { return positive(multipole.reflectance(r)); }
  T transmittance(const T& r) const { return positive(multipole.transmittance(r)); }
  T total() const { return multipole.total_reflectance(); }
  T total_transmittance() const { return multipole.total_transmittance(); }
  T core_radius() const { return multipole.slab.depth; }

 private:
  static T positive(const T& value) { return value > 0.0 ? value : T(0.0); }
};

std::unique_ptr<Profile> build(const Medium<double>& m, const ProfileParameters& parameters) {
  const double thickness = number_of(parameters, "thickness_mm"), below = number_of(parameters, "index_below");
  if (!std::isfinite(thickness)) return make_formula_profile<StandardDipole, Dual>(m, parameters);
  const Medium<Dual> dual{Dual(m.sigma_a, 0), Dual(m.sigma_s_prime, 1), Dual(m.eta, 2)};
  const Slab<double> slab{m, thickness, m.eta / below};
  const Slab<Dual> dual_slab{dual, Dual(thickness), dual.eta / below};
  return std::make_unique<NumericProfile<SlabProfile, Dual>>(SlabProfile<double>{Multipole<double>(slab)},
                                                             SlabProfile<Dual>{Multipole<Dual>(dual_slab)});
}

}  // namespace

ProfileInfo multipole_profile() {
  return {
      .name = "multipole",
      .citation = "C. Donner, H. W. Jensen: Light Diffusion in Multi-Layered Translucent Materials, SIGGRAPH 2005",
      .domain = {.eta_min = 0.3,
                 .eta_max = 3.5,
                 .alpha_prime_min = 0.8,
                 .thickness_min_mfp = 2,
                 .note = "a slab; as the standard dipole beyond. At 2 transport mean free paths it says R = T; under "
                         "1.5 the source moves to 2/3 of the depth, under 1 part of the beam passes unscattered. "
                         "Needs both extrapolated boundaries within one thickness of each other, else R or T is 0 "
                         "far from the beam"},
      .monotone = true,
      .build = &build,
      .parameters = {{.name = "thickness_mm",
                      .unit = "mm",
                      .fallback = HUGE_VAL,
                      .low = 1e-60,
                      .high = HUGE_VAL,
                      .meaning = "of the slab; infinite: a half space, the standard dipole"},
                     {.name = "index_below",
                      .unit = "1",
                      .fallback = 1.0,
                      .low = 1e-3,
                      .high = 1e3,
                      .meaning = "refraction index of the space under the slab over that above it"}},
      .has_transmittance = true};
}

}  // namespace opaline
