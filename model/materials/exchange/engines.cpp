// Profile numbers of game engines. They have no phase function: similarity stands in for g.
#include "model/materials/exchange/fields.h"

#include <algorithm>
#include <cmath>

namespace opaline::exchange {
namespace {

/// x with 99.7 % of Burley's profile inside d x: the filter radius of HDRP. 1 - e^-x/4 - 3 e^(-x/3)/4 = .997, by
/// Newton.
double burley_radius() {
  double x = 16;
  for (int i = 0; i < 50; ++i) {
    const double left = 0.25 * std::exp(-x) + 0.75 * std::exp(-x / 3) - 0.003;
    x += left / (0.25 * std::exp(-x) + 0.25 * std::exp(-x / 3));
  }
  return x;
}

}  // namespace

std::string write_unreal(const ExchangeMaterial& m, const ExchangeSettings& s) {
  const Rgb path = each([&](std::size_t c) { return 0.1 / m.sigma_t_prime(c); });  // cm
  const double longest = std::max({path[0], path[1], path[2]});
  return "{\n  \"name\": \"" + m.name +
         "\",\n  \"enable_burley\": true,\n  \"enable_mean_free_path\": true,\n  \"surface_albedo\": [" +
         triple(colours(m, s.colour), ", ") + "],\n  \"mean_free_path_color\": [" +
         triple(each([&](std::size_t c) { return path[c] / longest; }), ", ") +
         "],\n  \"mean_free_path_distance\": " + number(longest * 10 / s.mm_per_unit) +
         ",\n  \"world_unit_scale\": " + number(s.mm_per_unit / 10) + ",\n  \"ior\": " + number(m.eta) + "\n}\n";
}

ExchangeMaterial read_unreal(const std::string& text, const ExchangeSettings& s) {
  const Rgb share = triple_after(text, "\"mean_free_path_color\"");
  const double longest = number_after(text, "\"mean_free_path_distance\"") * number_after(text, "\"world_unit_scale\"");
  const double eta = number_after(text, "\"ior\"");
  return from_reduced(absorbed_of(triple_after(text, "\"surface_albedo\""), eta, s.colour),
                      each([&](std::size_t c) { return 0.1 / (share[c] * longest); }), 0, eta);
}

std::string write_unity(const ExchangeMaterial& m, const ExchangeSettings& s) {
  const Rgb colour = colours(m, s.colour);
  const Rgb d = each([&](std::size_t c) { return 1 / (m.sigma_t_prime(c) * burley_shape(colour[c])); });  // mm
  return "{\n  \"name\": \"" + m.name + "\",\n  \"base_color\": [" + triple(colour, ", ") +
         "],\n  \"scattering_distance_mm\": [" + triple(d, ", ") +
         "],\n  \"max_radius_mm\": " + number(burley_radius() * std::max({d[0], d[1], d[2]})) +
         ",\n  \"world_scale_m_per_unit\": " + number(s.mm_per_unit / 1000) +
         ",\n  \"index_of_refraction\": " + number(m.eta) + "\n}\n";
}

ExchangeMaterial read_unity(const std::string& text, const ExchangeSettings& s) {
  const Rgb colour = triple_after(text, "\"base_color\""), d = triple_after(text, "\"scattering_distance_mm\"");
  const double eta = number_after(text, "\"index_of_refraction\"");
  return from_reduced(absorbed_of(colour, eta, s.colour),
                      each([&](std::size_t c) { return 1 / (d[c] * burley_shape(colour[c])); }), 0, eta);
}

}  // namespace opaline::exchange
