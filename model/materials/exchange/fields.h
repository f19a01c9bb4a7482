// Numbers into text and out of it: what all formats share.
#pragma once

#include "model/materials/exchange.h"

namespace opaline::exchange {

using Rgb = std::array<double, 3>;

/// Seventeen digits: the same double when read back.
std::string number(double value);
/// Three numbers with `separator` between.
std::string triple(const Rgb& v, const char* separator);

/// The numbers that follow the first occurrence of `key` in the text, after the characters between (quotes, brackets,
/// `value=`, colons). Throws std::invalid_argument naming the key.
double number_after(const std::string& text, const std::string& key);
Rgb triple_after(const std::string& text, const std::string& key);

/// From 1 - alpha' and sigma_t' per channel.
ExchangeMaterial from_reduced(const Rgb& absorbed, const Rgb& sigma_t_prime, double g, double eta);
/// From 1 - alpha and sigma_t.
ExchangeMaterial from_unreduced(const Rgb& absorbed, const Rgb& sigma_t, double g, double eta);

/// Colours of all channels, and 1 - alpha' of colours.
Rgb colours(const ExchangeMaterial& m, ColourMeaning meaning);
Rgb absorbed_of(const Rgb& colour, double eta, ColourMeaning meaning);

/// body(c) for every channel.
template <typename Body>
Rgb each(const Body& body) {
  return {body(std::size_t{0}), body(std::size_t{1}), body(std::size_t{2})};
}

}  // namespace opaline::exchange
