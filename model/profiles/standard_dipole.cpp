#include "model/profiles/standard_dipole.h"

#include "model/profiles/formula_profile.h"

#include <ceres/jet.h>

namespace opaline {

ProfileInfo standard_dipole_profile() {
  return {
      .name = "standard_dipole",
      .citation =
          "H. W. Jensen, S. R. Marschner, M. Levoy, P. Hanrahan: A Practical Model for Subsurface Light "
          "Transport, SIGGRAPH 2001",
      .domain = {.eta_min = 0.3,
                 .eta_max = 3.5,
                 .alpha_prime_min = 0.8,
                 .note = "diffusion with a point source: against transport the total is off by up to 36 % at "
                         "alpha' 0.8, 10 % at 0.95, 2 % at 0.99 (eta 1 to 1.5); R_d is far too low within a third of a "
                         "transport mean free path and 1.2 to 1.6 times too high around one"},
      .monotone = true,
      .build = &make_formula_profile<StandardDipole, ceres::Jet<double, 3>>};
}

}  // namespace opaline
