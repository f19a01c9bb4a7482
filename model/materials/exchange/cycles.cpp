// Blender's Principled BSDF, both conventions of its subsurface radius.
#include "model/conventions.h"
#include "model/materials/exchange/fields.h"

namespace opaline::exchange {
namespace {

std::string sockets(const std::string& comment, const Rgb& colour, const Rgb& radius, double g, double eta) {
  return comment + "\nprincipled.inputs[\"Base Color\"].default_value = (" + triple(colour, ", ") +
         ", 1)\nprincipled.inputs[\"Subsurface Weight\"].default_value = 1\n" +
         "principled.inputs[\"Subsurface Radius\"].default_value = (" + triple(radius, ", ") +
         ")\nprincipled.inputs[\"Subsurface Scale\"].default_value = 1\n" +
         "principled.inputs[\"Subsurface Anisotropy\"].default_value = " + number(g) +
         "\nprincipled.inputs[\"IOR\"].default_value = " + number(eta) + "\n";
}

struct Sockets {
  Rgb colour, radius;
  double g, eta;
};

Sockets read_sockets(const std::string& text) {
  const auto socket = [](const char* name) { return std::string("[\"") + name + "\"].default_value"; };
  Sockets v{triple_after(text, socket("Base Color")), triple_after(text, socket("Subsurface Radius")),
            number_after(text, socket("Subsurface Anisotropy")), number_after(text, socket("IOR"))};
  const double scale = number_after(text, socket("Subsurface Scale"));
  for (double& r : v.radius) r *= scale;
  return v;
}

}  // namespace

std::string write_cycles(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return sockets(
      "# " + m.name + ": method Random Walk since 2026; radius is the mean free path 1/sigma_t in scene units of " +
          number(s.mm_per_unit) + " mm; colour is " + colour_meaning_name(s.colour),
      colours(m, s.colour), each([&](std::size_t c) { return 1 / (m.sigma_t(c) * s.mm_per_unit); }), m.g, m.eta);
}

ExchangeMaterial read_cycles(const std::string& text, const ExchangeSettings& s) {
  const Sockets v = read_sockets(text);
  const Rgb reduced = absorbed_of(v.colour, v.eta, s.colour);
  return from_unreduced(each([&](std::size_t c) { return unreduced_absorbed(reduced[c], v.g); }),
                        each([&](std::size_t c) { return 1 / (v.radius[c] * s.mm_per_unit); }), v.g, v.eta);
}

std::string write_cycles_legacy(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return sockets("# " + m.name +
                     ": methods Burley and Random Walk of files up to 5.x; radius is 4 pi/sigma_t' in scene units of " +
                     number(s.mm_per_unit) + " mm; colour is " + colour_meaning_name(s.colour),
                 colours(m, s.colour),
                 each([&](std::size_t c) { return 4 * pi / (m.sigma_t_prime(c) * s.mm_per_unit); }), m.g, m.eta);
}

ExchangeMaterial read_cycles_legacy(const std::string& text, const ExchangeSettings& s) {
  const Sockets v = read_sockets(text);
  return from_reduced(absorbed_of(v.colour, v.eta, s.colour),
                      each([&](std::size_t c) { return 4 * pi / (v.radius[c] * s.mm_per_unit); }), v.g, v.eta);
}

}  // namespace opaline::exchange
