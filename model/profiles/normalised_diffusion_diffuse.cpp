#include "model/profiles/normalised_diffusion.h"

#include "model/profiles/formula_profile.h"

#include <ceres/jet.h>

namespace opaline {

ProfileInfo normalised_diffusion_diffuse_profile() {
  return {.name = "normalised_diffusion_diffuse",
          .citation =
              "P. H. Christensen, B. Burley: Approximate Reflectance Profiles for Efficient Subsurface "
              "Scattering, Pixar 2015",
          .domain = {.eta_min = 0.8,
                     .eta_max = 2.0,
                     .alpha_prime_min = 0.1,
                     .note = "as normalised_diffusion, for diffuse light: van de Hulst's albedo (within 0.002 at eta "
                             "1; behind a boundary it takes "
                             "the light inside as diffuse too, which is 10 % too bright at eta 1.3 and alpha' 0.9) and "
                             "the shape fitted "
                             "to diffuse transmission"},
          .monotone = true,
          .build = &make_formula_profile<DiffuseNormalisedDiffusion, ceres::Jet<double, 3>>};
}

}  // namespace opaline
