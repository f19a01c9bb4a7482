// Mitsuba 3: a homogeneous medium inside a smooth dielectric. Only sigma_t and albedo are accepted there.
#include "model/materials/exchange/fields.h"

namespace opaline::exchange {

std::string write_mitsuba(const ExchangeMaterial& m, const ExchangeSettings& s) {
  const Rgb sigma_t = each([&](std::size_t c) { return m.sigma_t(c); });
  const Rgb albedo = each([&](std::size_t c) { return m.sigma_s(c) / m.sigma_t(c); });
  // 1 - albedo loses digits where little is absorbed: the absorption stands beside it in the comment.
  return "<!-- " + m.name +
         ": sigma_t in 1/mm; scale is the length of a scene unit in mm; albedo is single-scattering.\n" +
         "     sigma_a per mm: " + triple(m.sigma_a, " ") + " -->\n<medium type=\"homogeneous\" id=\"" + m.name +
         "\">\n  <rgb name=\"sigma_t\" value=\"" + triple(sigma_t, ", ") + "\"/>\n  <rgb name=\"albedo\" value=\"" +
         triple(albedo, ", ") + "\"/>\n  <float name=\"scale\" value=\"" + number(s.mm_per_unit) +
         "\"/>\n  <phase type=\"hg\">\n    <float name=\"g\" value=\"" + number(m.g) +
         "\"/>\n  </phase>\n</medium>\n<bsdf type=\"dielectric\">\n  <float name=\"int_ior\" value=\"" + number(m.eta) +
         "\"/>\n  <float name=\"ext_ior\" value=\"1\"/>\n</bsdf>\n";
}

ExchangeMaterial read_mitsuba(const std::string& text, const ExchangeSettings&) {
  const Rgb sigma_t = triple_after(text, "name=\"sigma_t\""), albedo = triple_after(text, "name=\"albedo\"");
  const double g = number_after(text, "name=\"g\""), eta = number_after(text, "name=\"int_ior\"");
  return from_unreduced(each([&](std::size_t c) { return 1 - albedo[c]; }), sigma_t, g, eta);
}

}  // namespace opaline::exchange
