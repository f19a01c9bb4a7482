#include "model/materials/albedo.h"

#include "model/profiles/profile.h"

#include <stdexcept>

namespace opaline {
namespace {

/// Share of a normal beam's transmitted flux that leaves a half space.
double rendered_colour(double absorbed, double eta) {
  return find_profile("transport_table")->make({absorbed, 1 - absorbed, eta})->total();
}

/// ln(1 - alpha') of a colour by false position (Illinois): the colour falls as it grows.
double rendered_absorbed(double colour, double eta) {
  double low = std::log(1e-12), high = 0, above = rendered_colour(std::exp(low), eta) - colour, below = -colour;
  if (above <= 0) return std::exp(low);
  if (below >= 0) return 1;
  double middle = low;
  for (int i = 0, last = 0; i < 100 && high - low > 1e-13; ++i) {
    const double before = middle;
    middle = (low * below - high * above) / (below - above);
    const double value = rendered_colour(std::exp(middle), eta) - colour;
    if (value == 0 || std::abs(middle - before) < 1e-14) break;
    (value > 0 ? low : high) = middle;
    (value > 0 ? above : below) = value;
    const int side = value > 0 ? 1 : -1;
    if (side == last) (side > 0 ? below : above) /= 2;
    last = side;
  }
  return std::exp(middle);
}

}  // namespace

ColourMeaning parse_colour_meaning(const std::string& text) {
  if (text == "van_de_hulst") return ColourMeaning::van_de_hulst;
  if (text == "rendered") return ColourMeaning::rendered;
  throw std::invalid_argument("'" + text + "' is not a meaning of colour; valid: van_de_hulst, rendered");
}

std::string colour_meaning_name(ColourMeaning meaning) {
  return meaning == ColourMeaning::rendered ? "rendered" : "van_de_hulst";
}

double multiple_scattering_colour(double absorbed, double eta, ColourMeaning meaning) {
  return meaning == ColourMeaning::rendered ? rendered_colour(absorbed, eta) : van_de_hulst_colour(absorbed);
}

double absorbed_of_colour(double colour, double eta, ColourMeaning meaning) {
  if (!(colour >= 0 && colour <= 1))
    throw std::invalid_argument("a multiple-scattering colour lies in 0 .. 1, but one is " + std::to_string(colour));
  return meaning == ColourMeaning::rendered ? rendered_absorbed(colour, eta) : van_de_hulst_absorbed(colour);
}

}  // namespace opaline
