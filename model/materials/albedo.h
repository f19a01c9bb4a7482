// What "albedo" and "colour" mean to other programs. Three quantities are called so:
//
//   alpha   = sigma_s/(sigma_a + sigma_s)      single-scattering albedo, of one collision
//   alpha'  = sigma_s'/(sigma_a + sigma_s')    its reduced value: isotropic scattering that looks the same far away
//   C       a multiple-scattering colour: the share of the light that has entered which comes out again
//
// and C has two meanings in use:
//
//   van_de_hulst   white-sky reflectance of an index-matched half space, by the fit of van de Hulst as printed by Kulla
//                  and Conty 2017 (OpenPBR's suggestion, MaterialX, glTF, Cycles since 2026). |error in alpha| < .0052
//                  against the exact H function. Behind a real boundary the rendered colour is darker.
//   rendered       what a half space of this medium shows behind its own boundary: exact reflectance of a normal beam
//   per
//                  transmitted flux (transport_table), which is what OpenPBR defines its colour to be.
//
// At C = .5 and eta = 1.5 they mean alpha' = .912 and .982. Every map here has its inverse.
#pragma once

#include <cmath>
#include <string>

namespace opaline {

enum class ColourMeaning { van_de_hulst, rendered };

/// Throws std::invalid_argument naming the valid words: "van_de_hulst", "rendered".
ColourMeaning parse_colour_meaning(const std::string& text);
std::string colour_meaning_name(ColourMeaning meaning);

/// C of absorbed = 1 - alpha' in [0, 1] (Kulla, Conty 2017: Revisiting physically based shading at Imageworks).
template <typename T>
T van_de_hulst_colour(const T& absorbed) {
  using std::sqrt;
  const T s = sqrt(absorbed);
  return (1.0 - s) * (1.0 - 0.139 * s) / (1.0 + 1.17 * s);
}

/// The inverse: 1 - alpha' of C in [0, 1]. Exact for the formula above: the root of .139 s^2 - (1.139 + 1.17 C) s +
/// (1 - C) = 0 in the form without cancellation. (The printed 4.09712 + 4.20863 C - sqrt(...) is this, rounded.)
template <typename T>
T van_de_hulst_absorbed(const T& colour) {
  using std::sqrt;
  const T b = 1.139 + 1.17 * colour;
  const T s = 2.0 * (1.0 - colour) / (b + sqrt(b * b - 4.0 * 0.139 * (1.0 - colour)));
  return s * s;
}

/// 1 - alpha of 1 - alpha' for a mean scattering cosine g, and back: (1 - alpha') = (1 - alpha)/(1 - g alpha).
template <typename T>
T unreduced_absorbed(const T& absorbed, double g) {
  return absorbed * (1.0 - g) / (1.0 - g * absorbed);
}
template <typename T>
T reduced_absorbed(const T& absorbed, double g) {
  return absorbed / (1.0 - g * (1.0 - absorbed));
}

/// C of either meaning and its inverse (the inverse of `rendered` by false position in ln(1 - alpha') down to 1e-12).
double multiple_scattering_colour(double absorbed, double eta, ColourMeaning meaning);
double absorbed_of_colour(double colour, double eta, ColourMeaning meaning);

/// Ratio of a mean free path to the length d of Burley's profile, d = l/s(A): Christensen, Burley 2015, for a
/// searchlight.
inline double burley_shape(double colour) { return 1.9 - colour + 3.5 * (colour - 0.8) * (colour - 0.8); }

}  // namespace opaline
