// What a fit may change: sigma_a and sigma_s' per colour channel and one eta. The solver sees
// ln sigma_a, ln sigma_s' (positive by construction) and eta, each within bounds.
#pragma once

#include "render/scene/scene.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace opaline {

inline constexpr int parameter_count = 7;
/// Solver order: ln sigma_a R G B, ln sigma_s' R G B, eta.
using ParameterVector = std::array<double, parameter_count>;
inline constexpr int eta_index = 6;

struct FreeParameters {
  bool sigma_a = true, sigma_s_prime = true, eta = true;
  std::array<bool, parameter_count> held{};  ///< single ones kept although their group is free
  bool is_free(int i) const {
    return (i < 3 ? sigma_a : (i < 6 ? sigma_s_prime : eta)) && !held[static_cast<std::size_t>(i)];
  }
};

/// What is known beforehand of one of the solver's parameters: a normal distribution.
struct Prior {
  int parameter;
  double mean, sd;  ///< of ln sigma or eta
};

struct ParameterBounds {
  double sigma_min = 1e-6, sigma_max = 1e4;  ///< [1/mm]
  double eta_min = 1.05, eta_max = 2.0;
  double lower(int i) const { return i == eta_index ? eta_min : std::log(sigma_min); }
  double upper(int i) const { return i == eta_index ? eta_max : std::log(sigma_max); }
};

/// "sigma_a_per_mm[R]", ..., "eta".
std::string parameter_name(int i);

ParameterVector to_parameters(const Material& material, const ParameterBounds& bounds);
/// `base` with the free parameters replaced; the others keep their exact values.
Material to_material(const ParameterVector& parameters, const Material& base, const FreeParameters& free = {});

/// The solver's value as the user's: exp of it for coefficients.
double natural_value(int i, double value);

/// "sigma_a,sigma_s_prime,eta" -> flags; one channel is "sigma_a[R]". Throws InputError naming the valid words.
FreeParameters parse_free(const std::string& text);

/// "eta=1.4:0.05" (mean, standard deviation; of coefficients in 1/mm, all channels or one: "sigma_a[R]=0.03:0.01").
/// Coefficients have a log-normal prior of relative width sd/mean. Throws InputError.
std::vector<Prior> parse_prior(const std::string& text);

}  // namespace opaline
