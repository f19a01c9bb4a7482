#include "model/profiles/normalised_diffusion.h"

#include "model/profiles/formula_profile.h"

#include <ceres/jet.h>

namespace opaline {

ProfileInfo normalised_diffusion_profile() {
  return {.name = "normalised_diffusion",
          .citation =
              "P. H. Christensen, B. Burley: Approximate Reflectance Profiles for Efficient Subsurface "
              "Scattering, Pixar 2015",
          .domain = {.eta_min = 0.8,
                     .eta_max = 2.0,
                     .alpha_prime_min = 0.1,
                     .note = "fitted to normal beams on index-matched half spaces, where the shape is within 3 % of "
                             "the flux (alpha' 0.8 to "
                             "0.95; 16 % at 0.999); behind a boundary of eta 1.3 14 % at 0.9 and 40 % at 0.999. Its "
                             "albedo comes from "
                             "Prahl's fit and Saunderson's correction. The 1/r at the axis is smoothed below d/100"},
          .monotone = true,
          .build = &make_formula_profile<SearchlightNormalisedDiffusion, ceres::Jet<double, 3>>};
}

}  // namespace opaline
