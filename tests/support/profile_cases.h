// Parameters for tests that go through the registry: what each kind of parameter may be.
#pragma once

#include "model/profiles/profile.h"

#include <cmath>

namespace opaline {

/// A measured profile, steep and not a formula of this project.
inline std::vector<ProfileSample> example_samples() {
  std::vector<ProfileSample> samples;
  for (double r = .02; r < 12; r *= 1.2) samples.push_back({r, .3 * std::exp(-1.7 * r) / (r + .1)});
  return samples;
}

/// Sets of parameters for a row: none if it needs none, else some that use every parameter. `mean_free_path` [mm]
/// makes slabs thin and thick.
inline std::vector<ProfileParameters> example_parameters(const ProfileInfo& info, double mean_free_path) {
  const double l = mean_free_path;
  std::vector<ProfileParameters> sets;
  if (info.needs_medium_alone()) sets.push_back({});
  for (const ProfileParameter& p : info.parameters) {
    if (p.kind == ParameterKind::samples) sets.push_back({{p.name, example_samples()}});
    if (p.name == "terms") sets.push_back({{"terms", 4.0}, {"of", std::string("better_dipole")}});
    if (p.name == "thickness_mm") {
      sets.push_back({{p.name, 2.5 * l}});
      sets.push_back({{p.name, 30 * l}, {"index_below", 1.2}});
    }
    if (p.kind == ParameterKind::layers) {
      const std::vector<Layer> layers = {Layer{{.3 / l, 2 / l, 1.4}, 3 * l}, Layer{{.01 / l, .5 / l, 1.2}, HUGE_VAL}};
      sets.push_back({{"thickness_mm", 4 * l}, {p.name, layers}});
    }
  }
  return sets;
}

/// The same parameters when all coefficients are k times as large: lengths are 1/k.
inline ProfileParameters in_other_units(const ProfileInfo& info, ProfileParameters parameters, double k) {
  for (const ProfileParameter& p : info.parameters) {
    const auto it = parameters.find(p.name);
    if (it == parameters.end() || p.unit != "mm") continue;
    if (double* number = std::get_if<double>(&it->second)) *number /= k;
    if (auto* layers = std::get_if<std::vector<Layer>>(&it->second)) {
      for (Layer& layer : *layers) {
        layer.medium.sigma_a *= k;
        layer.medium.sigma_s_prime *= k;
        layer.thickness /= k;
      }
    }
  }
  return parameters;
}

}  // namespace opaline
