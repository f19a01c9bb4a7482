#include "model/materials/exchange/fields.h"

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace opaline::exchange {
namespace {

/// `count` numbers from `key` on; between key and first number only punctuation and the words that formats put there.
std::vector<double> numbers_after(const std::string& text, const std::string& key, std::size_t count) {
  std::size_t at = text.find(key);
  if (at == std::string::npos) throw std::invalid_argument("the field " + key + " is missing");
  at += key.size();
  std::vector<double> values;
  while (values.size() < count && at < text.size() && text[at] != '\n') {
    const char* begin = text.c_str() + at;
    char* end = nullptr;
    const char first = *begin;
    const bool may_start = (first >= '0' && first <= '9') || first == '-' || first == '.';
    const double value = may_start ? std::strtod(begin, &end) : 0;
    if (may_start && end != begin) {
      values.push_back(value);
      at += static_cast<std::size_t>(end - begin);
    } else {
      ++at;
    }
  }
  if (values.size() < count)
    throw std::invalid_argument("the field " + key + " needs " + std::to_string(count) + " numbers on its line");
  return values;
}

}  // namespace

std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

std::string triple(const Rgb& v, const char* separator) {
  return number(v[0]) + separator + number(v[1]) + separator + number(v[2]);
}

double number_after(const std::string& text, const std::string& key) { return numbers_after(text, key, 1)[0]; }

Rgb triple_after(const std::string& text, const std::string& key) {
  const std::vector<double> v = numbers_after(text, key, 3);
  return {v[0], v[1], v[2]};
}

ExchangeMaterial from_reduced(const Rgb& absorbed, const Rgb& sigma_t_prime, double g, double eta) {
  ExchangeMaterial m;
  for (std::size_t c = 0; c < 3; ++c) {
    m.sigma_a[c] = absorbed[c] * sigma_t_prime[c];
    m.sigma_s_prime[c] = (1 - absorbed[c]) * sigma_t_prime[c];
  }
  m.g = g, m.eta = eta;
  return m;
}

ExchangeMaterial from_unreduced(const Rgb& absorbed, const Rgb& sigma_t, double g, double eta) {
  ExchangeMaterial m;
  for (std::size_t c = 0; c < 3; ++c) {
    m.sigma_a[c] = absorbed[c] * sigma_t[c];
    m.sigma_s_prime[c] = (1 - absorbed[c]) * sigma_t[c] * (1 - g);
  }
  m.g = g, m.eta = eta;
  return m;
}

Rgb colours(const ExchangeMaterial& m, ColourMeaning meaning) {
  return each([&](std::size_t c) { return multiple_scattering_colour(m.absorbed(c), m.eta, meaning); });
}

Rgb absorbed_of(const Rgb& colour, double eta, ColourMeaning meaning) {
  return each([&](std::size_t c) { return absorbed_of_colour(colour[c], eta, meaning); });
}

}  // namespace opaline::exchange
