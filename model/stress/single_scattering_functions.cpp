// Single scattering of a half space and of layers.
#include "model/single_scattering/layered.h"
#include "model/stress/function.h"

#include <limits>

namespace opaline {
namespace {

Axis g_axis() { return {"g", {-0.95, 0, 0.95}, 0.05, 1, Spread::signed_share}; }
Axis cosine(const std::string& name) { return {name, {1e-6, 0.5, 1}, 1e-6, 1}; }

/// (sigma_a, sigma_s, eta, g) and a distance in mean free paths.
Domain scattering_domain(bool with_distance) {
  Domain domain = medium_domain(0.3, 3.5);
  domain.axes.push_back(g_axis());
  domain.inputs = {"sigma_a", "sigma_s", "eta", "g"};
  domain.to_inputs = &to_medium;
  if (!with_distance) return domain;
  domain.axes.push_back({"r sigma_t", {1e-12, 1, 100}, 1e-12, 300});
  domain.inputs.push_back("r");
  domain.to_inputs = [](Input& x) {
    x[4] /= x[0];
    to_medium(x);
  };
  return domain;
}

template <typename T>
ScatteringMedium<T> scatterer(const T* x, Phase phase) {
  return {x[0], x[1], x[3], x[2], phase};
}

template <Phase phase>
void add_half_space(std::vector<StressFunction>& rows, const std::string& name) {
  const auto profile = [](const auto* x) { return single_scattering_profile(scatterer(x, phase), x[4]); };
  const auto cumulative = [](const auto* x) { return single_scattering_cumulative(scatterer(x, phase), x[4]); };
  const auto total = [](const auto* x) { return single_scattering_total(scatterer(x, phase)); };
  rows.push_back(with_cost(
      with_monotone(stress_function(name + ".profile", scattering_domain(true), loose_limit, profile), {4, false}),
      32));
  rows.push_back(with_cost(
      with_monotone(stress_function(name + ".cumulative", scattering_domain(true), loose_limit, cumulative), {4, true}),
      32));
  rows.push_back(with_cost(stress_function(name + ".total", scattering_domain(false), loose_limit, total), 32));
}

/// A layer of optical thickness x[3] above a half space of another index and phase function.
Domain layers_domain() {
  return {.axes = {g_axis(),
                   eta_axis(0.3, 3.5),
                   {"tau", {1e-12, 1, 1e3}, 1e-12, 1e3},
                   cosine("cos_i"),
                   cosine("cos_o"),
                   {"cos_azimuth", {-1, 0, 1}, -1, 1, Spread::linear}}};
}

}  // namespace

void add_single_scattering_functions(std::vector<StressFunction>& rows) {
  add_half_space<Phase::henyey_greenstein>(rows, "single_scattering");
  add_half_space<Phase::schlick>(rows, "single_scattering_schlick");
  const auto brdf = []<typename T>(const T* x) {
    const std::vector<ScatteringLayer<T>> layers = {
        {{T(0.25), T(0.75), x[0], x[1]}, x[2]},
        {{T(0.125), T(2.0), T(0.25), T(1.25), Phase::schlick}, T(std::numeric_limits<double>::infinity())}};
    return layered_single_scattering_brdf(layers, x[3], x[4], x[5]);
  };
  rows.push_back(with_cost(stress_function("layered_single_scattering_brdf", layers_domain(), loose_limit, brdf), 4));
}

}  // namespace opaline
