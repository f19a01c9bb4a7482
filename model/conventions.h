// Units, frames and normalisation: the one page every other header refers to.
//
//   length        mm                      coefficients  1/mm
//   eta           n_inside / n_outside    radiance      linear (scene-referred) RGB
//   directions    unit vectors pointing away from the surface; a light's `direction` is the way
//                 the light travels
//
// Diffuse reflectance profile R_d(r) [1/mm^2]: radiant exitance per unit of flux that has ENTERED
// the medium (per transmitted flux). Irradiance E therefore carries the entering Fresnel factor
// F_t, and
//
//   B(x)  = integral of R_d(|x - x'|) E(x') dA          radiant exitance below the exit lobe
//   L_o   = F_t(eta, w_o) B / (pi c)                    outgoing radiance
//
// where c = 1 - 2 C_1(1/eta), the cosine-weighted mean of F_t over the outside hemisphere, for the
// `normalised` exit lobe (energy agrees with transport) and c = 1 for `jensen` (as the papers
// print it). See `exit_lobe_normalisation` in fresnel.h.
#pragma once

namespace opaline {

inline constexpr double pi = 3.14159265358979323846264338327950288;

/// Homogeneous participating medium, one colour channel.
///   sigma_a        absorption coefficient [1/mm], >= 0
///   sigma_s_prime  reduced scattering coefficient (1 - g) sigma_s [1/mm], >= 0;
///                  sigma_a + sigma_s_prime > 0
///   eta            relative refraction index inside / outside, > 0
template <typename T>
struct Medium {
  T sigma_a{};
  T sigma_s_prime{};
  T eta{1};
};

/// Which normalisation the directional exit lobe F_t(eta, w_o)/(pi c) has.
enum class ExitLobe { normalised, jensen };

}  // namespace opaline
