#include "model/profiles/tabulated_profile.h"

#include <cmath>

namespace opaline {
namespace {

std::unique_ptr<Profile> build(const Medium<double>&, const ProfileParameters& parameters) {
  return std::make_unique<TabulatedProfile>(std::get<std::vector<ProfileSample>>(parameters.at("samples")));
}

}  // namespace

ProfileInfo tabulated_profile() {
  return {.name = "tabulated",
          .citation =
              "F. N. Fritsch, J. Butland: A Method for Constructing Local Monotone Piecewise Cubic "
              "Interpolants, SIAM J. Sci. Stat. Comput. 5, 1984 (the interpolation)",
          .domain = {.eta_min = 0,
                     .eta_max = HUGE_VAL,
                     .alpha_prime_min = 0,
                     .note = "as measured: the medium doesn't matter, gradients by it are 0. Flat below the first "
                             "radius, exponential beyond the last; monotone where the samples are"},
          .monotone = false,
          .build = &build,
          .parameters = {{.name = "samples",
                          .kind = ParameterKind::samples,
                          .unit = "mm, 1/mm^2",
                          .meaning = "R_d at two radii or more, as a CSV file with the columns r and R"}},
          .conserves_energy = false,
          .depends_on_medium = false};
}

}  // namespace opaline
