// MaterialX documents: OpenPBR Surface and Autodesk Standard Surface. Both speak of mean free paths 1/sigma_t
// (unreduced, in scene units) and of a multiple-scattering colour.
#include "model/materials/exchange/fields.h"

#include <algorithm>

namespace opaline::exchange {
namespace {

std::string input(const char* name, const char* type, const std::string& value) {
  return std::string("    <input name=\"") + name + "\" type=\"" + type + "\" value=\"" + value + "\"/>\n";
}

Rgb radii(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return each([&](std::size_t c) { return 1 / (m.sigma_t(c) * s.mm_per_unit); });
}

std::string document(const ExchangeMaterial& m, const ExchangeSettings& s, const char* node,
                     const std::string& inputs) {
  return "<?xml version=\"1.0\"?>\n<!-- " + m.name + ": radii in scene units of " + number(s.mm_per_unit) +
         " mm; colour is " + colour_meaning_name(s.colour) +
         " -->\n<materialx version=\"1.39\" colorspace=\"lin_rec709\">\n  <" + node + " name=\"" + m.name +
         "_surface\" type=\"surfaceshader\">\n" + inputs + "  </" + node + ">\n  <surfacematerial name=\"" + m.name +
         "\" type=\"material\">\n    <input name=\"surfaceshader\" " + "type=\"surfaceshader\" nodename=\"" + m.name +
         "_surface\"/>\n  </surfacematerial>\n</materialx>\n";
}

ExchangeMaterial read_common(const std::string& text, const ExchangeSettings& s, const Rgb& radius, double g) {
  const double eta = number_after(text, "name=\"specular_IOR\" type=\"float\"");
  const Rgb colour = triple_after(text, "name=\"subsurface_color\" type=\"color3\"");
  const Rgb reduced = absorbed_of(colour, eta, s.colour);
  return from_unreduced(each([&](std::size_t c) { return unreduced_absorbed(reduced[c], g); }),
                        each([&](std::size_t c) { return 1 / (radius[c] * s.mm_per_unit); }), g, eta);
}

}  // namespace

std::string write_openpbr(const ExchangeMaterial& m, const ExchangeSettings& s) {
  const Rgb r = radii(m, s);
  const double largest = std::max({r[0], r[1], r[2]});
  return document(m, s, "open_pbr_surface",
                  input("base_weight", "float", "1") + input("subsurface_weight", "float", "1") +
                      input("subsurface_color", "color3", triple(colours(m, s.colour), ", ")) +
                      input("subsurface_radius", "float", number(largest)) +
                      input("subsurface_radius_scale", "color3",
                            triple(each([&](std::size_t c) { return r[c] / largest; }), ", ")) +
                      input("subsurface_scatter_anisotropy", "float", number(m.g)) +
                      input("specular_ior", "float", number(m.eta)));
}

ExchangeMaterial read_openpbr(const std::string& text, const ExchangeSettings& s) {
  const double largest = number_after(text, "name=\"subsurface_radius\" type=\"float\"");
  const Rgb scale = triple_after(text, "name=\"subsurface_radius_scale\" type=\"color3\"");
  const double g = number_after(text, "name=\"subsurface_scatter_anisotropy\" type=\"float\"");
  std::string renamed = text;  // the two standards differ in the case of one name
  const std::size_t at = renamed.find("specular_ior");
  if (at != std::string::npos) renamed.replace(at, 12, "specular_IOR");
  return read_common(renamed, s, each([&](std::size_t c) { return largest * scale[c]; }), g);
}

std::string write_standard_surface(const ExchangeMaterial& m, const ExchangeSettings& s) {
  return document(m, s, "standard_surface",
                  input("base", "float", "1") + input("subsurface", "float", "1") +
                      input("subsurface_color", "color3", triple(colours(m, s.colour), ", ")) +
                      input("subsurface_radius", "color3", triple(radii(m, s), ", ")) +
                      input("subsurface_scale", "float", "1") + input("subsurface_anisotropy", "float", number(m.g)) +
                      input("specular_IOR", "float", number(m.eta)));
}

ExchangeMaterial read_standard_surface(const std::string& text, const ExchangeSettings& s) {
  const Rgb radius = triple_after(text, "name=\"subsurface_radius\" type=\"color3\"");
  const double scale = number_after(text, "name=\"subsurface_scale\" type=\"float\"");
  const double g = number_after(text, "name=\"subsurface_anisotropy\" type=\"float\"");
  return read_common(text, s, each([&](std::size_t c) { return radius[c] * scale; }), g);
}

}  // namespace opaline::exchange
