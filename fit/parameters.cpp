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
    if (free.sigma_a) material.sigma_a[c] = std::exp(parameters[static_cast<std::size_t>(c)]);
    if (free.sigma_s_prime) material.sigma_s_prime[c] = std::exp(parameters[static_cast<std::size_t>(c) + 3]);
  }
  if (free.eta) material.eta = parameters[eta_index];
  return material;
}

double natural_value(int i, double value) { return i == eta_index ? value : std::exp(value); }

FreeParameters parse_free(const std::string& text) {
  FreeParameters free{false, false, false};
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    if (word == "sigma_a")
      free.sigma_a = true;
    else if (word == "sigma_s_prime")
      free.sigma_s_prime = true;
    else if (word == "eta")
      free.eta = true;
    else
      throw InputError("--free", "", "'" + word + "' is not one of sigma_a, sigma_s_prime, eta");
  }
  if (!free.sigma_a && !free.sigma_s_prime && !free.eta)
    throw InputError("--free", "", "names no parameter; valid: sigma_a, sigma_s_prime, eta");
  return free;
}

}  // namespace opaline
