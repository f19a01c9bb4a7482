// Measured materials as data: Jensen et al. 2001 (12) and Narasimhan et al. 2006 (35).
//
// Coefficients per RGB channel [1/mm]. A number that the source doesn't give is NaN. Corrections to
// copies in circulation: the red sigma_a of Chicken1 and Chicken2 is .015 and .018 (a tenth of it in
// Mitsuba 0.6 contradicts the published reflectances); drinks and powders are as diluted when measured.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace opaline {

struct MaterialRow {
  std::string set;                      ///< "jensen2001" or "narasimhan2006"
  std::string name;                     ///< as published: "Wholemilk", "Lowfat Milk"
  std::array<double, 3> sigma_s_prime;  ///< reduced scattering [1/mm]
  std::array<double, 3> sigma_a;        ///< absorption [1/mm]
  std::array<double, 3> g;              ///< mean scattering cosine, or NaN; 0 where sigma_s is 0
  std::array<double, 3> sigma_s;        ///< scattering [1/mm], or NaN
  double eta;                           ///< relative refraction index
  std::array<double, 3> published_rd;   ///< diffuse reflectance the source prints, or NaN
  std::string source;
};

/// All materials, in a fixed order.
const std::vector<MaterialRow>& material_library();

/// The material of that name, ignoring case and everything but letters and digits ("wholemilk",
/// "Whole Milk" and "whole_milk" are one), or nullptr.
const MaterialRow* find_material(const std::string& name);

/// The names find_material is sure to know, in library order: for messages and listings.
std::vector<std::string> material_names();

}  // namespace opaline
