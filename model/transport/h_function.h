// Exact totals of an isotropically scattering half space, without chance: Chandrasekhar's H function, and the
// integral equation that a smooth Fresnel boundary adds to it.
//
//   albedo       sigma_s/sigma_t, or alpha' by similarity, in [0, 1]
//   eta          inside / outside, in [0.3, 4]
//   mu, cosines  in [0, 1]; `cos_incident` is OUTSIDE
//
// Error: below 2e-9 absolute for every function. Each call solves its equation anew:
// 0.2 ms at eta = 1, about 5 ms at 1.5. Wrong arguments throw std::invalid_argument.
//
// Source: Chandrasekhar 1950 (H, invariance); derivation of the boundary's equation in h_function.cpp.
#pragma once

namespace opaline {

/// H(mu) of isotropic scattering.
double chandrasekhar_h(double albedo, double mu);

/// Diffuse reflectances of a half space, specular reflection left out unless the name says otherwise.
struct HalfSpaceAlbedo {
  double specular = 0, specular_white = 0;  // Fresnel reflectance of the beam, of diffuse light from outside
  double beam_per_transmitted = 0;          // a pencil or broad beam with cos_incident, per flux that has entered
  double beam_per_incident = 0;
  double beam_with_specular = 0;  // per incident flux
  double white_per_incident = 0;  // diffuse illumination
  double white_with_specular = 0;
};

HalfSpaceAlbedo half_space_albedo(double albedo, double eta, double cos_incident = 1);

}  // namespace opaline
