// Materials for other programs, and back. A format is one .cpp of exchange/ and one line of the table in exchange.cpp;
// each row says which fields it writes, in which units, and where that convention stands.
//
//   write(m, s)   text ready to paste into a scene of that program
//   read(text, s) the same material from the same fields: read(write(m)) = m to 1e-6, unless write() refused
#pragma once

#include "model/materials/albedo.h"

#include <array>
#include <string>
#include <vector>

namespace opaline {

/// What other programs are told: coefficients in 1/mm per RGB channel. sigma_s = sigma_s'/(1 - g).
struct ExchangeMaterial {
  std::string name = "opaline";
  std::array<double, 3> sigma_a{}, sigma_s_prime{};
  double g = 0;      ///< -1 < g < 1
  double eta = 1.5;  ///< inside over outside

  double sigma_s(std::size_t c) const { return sigma_s_prime[c] / (1 - g); }
  double sigma_t(std::size_t c) const { return sigma_a[c] + sigma_s(c); }
  double sigma_t_prime(std::size_t c) const { return sigma_a[c] + sigma_s_prime[c]; }
  /// 1 - alpha'.
  double absorbed(std::size_t c) const { return sigma_a[c] / sigma_t_prime(c); }
};

struct ExchangeSettings {
  double mm_per_unit = 0;  ///< of the other program's scene; 0: the format's own (1, or what its standard prescribes)
  ColourMeaning colour = ColourMeaning::van_de_hulst;
};

struct ExchangeFormat {
  std::string name, extension, summary;
  std::string convention;  ///< fields, units and meaning of its albedo
  std::string source;      ///< where that stands
  double mm_per_unit;      ///< used when the settings leave it open
  bool uses_colour;        ///< is ExchangeSettings::colour used?
  /// Throws std::invalid_argument if the format cannot say this material.
  std::string (*write)(const ExchangeMaterial&, const ExchangeSettings&);
  /// Throws std::invalid_argument naming the field that is missing or out of range.
  ExchangeMaterial (*read)(const std::string& text, const ExchangeSettings&);
};

const std::vector<ExchangeFormat>& exchange_formats();

/// Throws std::invalid_argument naming the formats there are.
const ExchangeFormat& find_exchange_format(const std::string& name);

/// With mm_per_unit filled in; throws std::invalid_argument for units or a material out of range: all finite,
/// coefficients >= 0, sigma_t' > 0, eta > 0, |g| < 1.
std::string write_material(const ExchangeFormat& format, const ExchangeMaterial& material, ExchangeSettings settings);
ExchangeMaterial read_material(const ExchangeFormat& format, const std::string& text, ExchangeSettings settings);

}  // namespace opaline
