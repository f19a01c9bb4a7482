// pbrt-v4: Material "subsurface" and a homogeneous named medium behind a dielectric.
#include "model/materials/exchange/fields.h"

namespace opaline::exchange {
namespace {

Rgb full_scattering(const ExchangeMaterial& m) {
  return each([&](std::size_t c) { return m.sigma_s(c); });
}

ExchangeMaterial read_coefficients(const std::string& text) {
  ExchangeMaterial m;
  m.g = number_after(text, "\"float g\"");
  m.eta = number_after(text, "\"float eta\"");
  m.sigma_a = triple_after(text, "\"rgb sigma_a\"");
  const Rgb sigma_s = triple_after(text, "\"rgb sigma_s\"");
  for (std::size_t c = 0; c < 3; ++c) m.sigma_s_prime[c] = (1 - m.g) * sigma_s[c];
  return m;
}

std::string coefficients(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return "  \"rgb sigma_a\" [ " + triple(m.sigma_a, " ") + " ]\n  \"rgb sigma_s\" [ " +
         triple(full_scattering(m), " ") + " ]\n  \"float scale\" [ " + number(s.mm_per_unit) + " ]\n  \"float g\" [ " +
         number(m.g) + " ]\n";
}

}  // namespace

std::string write_pbrt_subsurface(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return "# " + m.name +
         ": coefficients in 1/mm; scale is the length of a scene unit in mm\nMaterial \"subsurface\"\n" +
         coefficients(m, s) + "  \"float eta\" [ " + number(m.eta) + " ]\n";
}

std::string write_pbrt_medium(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return "# " + m.name + ": coefficients in 1/mm; scale is the length of a scene unit in mm; render with volpath\n" +
         "MakeNamedMedium \"" + m.name + "\"\n  \"string type\" [ \"homogeneous\" ]\n" + coefficients(m, s) +
         "# on the closed shape:\nMediumInterface \"" + m.name +
         "\" \"\"\nMaterial \"dielectric\"\n  \"float eta\" [ " + number(m.eta) + " ]\n";
}

/// The coefficients are in 1/mm whatever the scale: nothing of the scene's unit is needed to read them.
ExchangeMaterial read_pbrt(const std::string& text, const ExchangeSettings&) { return read_coefficients(text); }

}  // namespace opaline::exchange
