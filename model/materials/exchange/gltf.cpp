// glTF: KHR_materials_volume_scatter on top of KHR_materials_volume, read as extinction, in metres.
#include "model/materials/exchange/fields.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace opaline::exchange {

std::string write_gltf(const ExchangeMaterial& m, const ExchangeSettings& s) {
  const Rgb sigma_t = each([&](std::size_t c) { return m.sigma_t(c) * s.mm_per_unit; });
  const double distance = 1 / std::max({sigma_t[0], sigma_t[1], sigma_t[2]});
  const Rgb colour = each([&](std::size_t c) { return std::exp(-sigma_t[c] * distance); });
  return "{\n  \"name\": \"" + m.name +
         "\",\n  \"extensions\": {\n    \"KHR_materials_ior\": {\n      \"ior\": " + number(m.eta) +
         "\n    },\n    \"KHR_materials_transmission\": {\n      \"transmissionFactor\": 1\n    },\n" +
         "    \"KHR_materials_volume\": {\n      \"thicknessFactor\": 1,\n      \"attenuationDistance\": " +
         number(distance) + ",\n      \"attenuationColor\": [" + triple(colour, ", ") + "]\n    },\n" +
         "    \"KHR_materials_volume_scatter\": {\n      \"multiscatterColor\": [" +
         triple(colours(m, s.colour), ", ") + "],\n      \"scatterAnisotropy\": " + number(m.g) + "\n    }\n  }\n}\n";
}

ExchangeMaterial read_gltf(const std::string& text, const ExchangeSettings& s) {
  const double distance = number_after(text, "\"attenuationDistance\""),
               g = number_after(text, "\"scatterAnisotropy\""), eta = number_after(text, "\"ior\"");
  const Rgb attenuation = triple_after(text, "\"attenuationColor\"");
  const Rgb reduced = absorbed_of(triple_after(text, "\"multiscatterColor\""), eta, s.colour);
  for (const double a : attenuation)
    if (!(a > 0 && a < 1))
      throw std::invalid_argument("attenuationColor must lie between 0 and 1 to give an extinction");
  return from_unreduced(each([&](std::size_t c) { return unreduced_absorbed(reduced[c], g); }),
                        each([&](std::size_t c) { return -std::log(attenuation[c]) / (distance * s.mm_per_unit); }), g,
                        eta);
}

}  // namespace opaline::exchange
