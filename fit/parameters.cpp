#include "fit/parameters.h"

#include "render/input_error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace opaline {

std::string parameter_name(int i) {
  if (i == eta_index) return "eta";
  constexpr const char* channel[] = {"R", "G", "B"};
  return std::string(i < 3 ? "sigma_a_per_mm[" : "sigma_s_prime_per_mm[") + channel[i % 3] + "]";
}

ParameterVector to_parameters(const Material& material, const ParameterBounds& bounds) {
  ParameterVector p;
  for (int c = 0; c < 3; ++c) {
    p[static_cast<std::size_t>(c)] = std::log(std::max(material.sigma_a[c], bounds.sigma_min));
    p[static_cast<std::size_t>(c) + 3] = std::log(std::max(material.sigma_s_prime[c], bounds.sigma_min));
  }
  p[eta_index] = material.eta;
  return p;
}

Material to_material(const ParameterVector& parameters, const Material& base, const FreeParameters& free) {
  Material material = base;
  for (int c = 0; c < 3; ++c) {
    if (free.is_free(c)) material.sigma_a[c] = std::exp(parameters[static_cast<std::size_t>(c)]);
    if (free.is_free(c + 3)) material.sigma_s_prime[c] = std::exp(parameters[static_cast<std::size_t>(c) + 3]);
  }
  if (free.is_free(eta_index)) material.eta = parameters[eta_index];
  return material;
}

double natural_value(int i, double value) { return i == eta_index ? value : std::exp(value); }

namespace {

/// The solver's parameters that "sigma_a", "sigma_s_prime[G]" or "eta" names; empty if it names none.
std::vector<int> named_parameters(const std::string& word) {
  if (word == "eta") return {eta_index};
  const std::size_t bracket = word.find('[');
  const std::string group = word.substr(0, bracket);
  if (group != "sigma_a" && group != "sigma_s_prime") return {};
  const int first = group == "sigma_a" ? 0 : 3;
  if (bracket == std::string::npos) return {first, first + 1, first + 2};
  for (int c = 0; c < 3; ++c)
    if (word.substr(bracket) == std::string("[") + "RGB"[c] + "]") return {first + c};
  return {};
}

constexpr const char* valid_words = "sigma_a, sigma_s_prime, eta, or one channel as in sigma_a[R]";

}  // namespace

FreeParameters parse_free(const std::string& text) {
  std::array<bool, parameter_count> chosen{};
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const std::vector<int> named = named_parameters(word);
    if (named.empty()) throw InputError("--free", "", "'" + word + "' is not one of " + valid_words);
    for (const int i : named) chosen[static_cast<std::size_t>(i)] = true;
  }
  FreeParameters free{chosen[0] || chosen[1] || chosen[2], chosen[3] || chosen[4] || chosen[5], chosen[6], {}};
  if (!free.sigma_a && !free.sigma_s_prime && !free.eta)
    throw InputError("--free", "", std::string("names no parameter; valid: ") + valid_words);
  for (std::size_t i = 0; i < parameter_count; ++i) free.held[i] = !chosen[i];
  return free;
}

std::vector<Prior> parse_prior(const std::string& text) {
  const std::size_t equals = text.find('='), colon = text.find(':', equals == std::string::npos ? 0 : equals);
  const std::vector<int> named = named_parameters(text.substr(0, equals));
  if (named.empty() || equals == std::string::npos || colon == std::string::npos)
    throw InputError("--prior", "", "'" + text + "' is not NAME=MEAN:SD with NAME one of " + valid_words);
  const auto number = [&](const std::string& digits) {
    std::istringstream in(digits);
    double value = 0;
    if (!(in >> value) || !in.eof() || !(value > 0) || !std::isfinite(value))
      throw InputError("--prior", "", "'" + digits + "' in '" + text + "' is not a number above 0");
    return value;
  };
  const double mean = number(text.substr(equals + 1, colon - equals - 1)), sd = number(text.substr(colon + 1));
  std::vector<Prior> priors;
  for (const int i : named) priors.push_back(i == eta_index ? Prior{i, mean, sd} : Prior{i, std::log(mean), sd / mean});
  return priors;
}

}  // namespace opaline
