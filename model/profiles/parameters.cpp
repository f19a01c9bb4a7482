#include "model/profiles/profile.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace opaline {
namespace {

std::string text(double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%g", value);
  return buffer;
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
  return all;
}

[[noreturn]] void fail(const ProfileInfo& info, const std::string& what) {
  throw ProfileParameterError("profile " + info.name + ": " + what);
}

const char* kind_name(ParameterKind kind) {
  constexpr const char* names[] = {"a number", "a word", "a table of samples", "a list of layers"};
  return names[static_cast<std::size_t>(kind)];
}

/// What is wrong with a layer, or nothing.
std::string layer_fault(const Layer& layer, bool last) {
  const Medium<double>& m = layer.medium;
  const double sigma_t_prime = m.sigma_a + m.sigma_s_prime;
  if (!(m.sigma_a >= 0 && m.sigma_s_prime >= 0 && sigma_t_prime >= 1e-60 && sigma_t_prime <= 1e60))
    return "sigma_a and sigma_s' must be >= 0 with a sum from 1e-60 to 1e60 1/mm";
  if (!(m.eta >= 1e-3 && m.eta <= 1e3)) return "eta must be from 0.001 to 1000";
  if (!(layer.thickness > 0)) return "the thickness must be positive [mm]";
  if (!last && !std::isfinite(layer.thickness)) return "only the last layer may be infinitely thick";
  return {};
}

/// What is wrong with a value, or nothing.
std::string fault(const ProfileParameter& parameter, const ParameterValue& value) {
  if (value.index() != static_cast<std::size_t>(parameter.kind))
    return std::string("must be ") + kind_name(parameter.kind);
  if (const double* number = std::get_if<double>(&value)) {
    if (*number >= parameter.low && *number <= parameter.high) return {};
    return text(*number) + " is not in " + text(parameter.low) + " .. " + text(parameter.high) + " (" + parameter.unit +
           ")";
  }
  if (const auto* word = std::get_if<std::string>(&value)) {
    if (parameter.choices.empty() || std::ranges::find(parameter.choices, *word) != parameter.choices.end()) return {};
    return "\"" + *word + "\" is none of " + joined(parameter.choices);
  }
  if (const auto* layers = std::get_if<std::vector<Layer>>(&value)) {
    for (std::size_t i = 0; i < layers->size(); ++i) {
      const std::string wrong = layer_fault((*layers)[i], i + 1 == layers->size());
      if (!wrong.empty()) return "layer " + std::to_string(i + 1) + ": " + wrong;
    }
  }
  return {};
}

std::string parameter_names(const ProfileInfo& info) {
  std::vector<std::string> names;
  for (const ProfileParameter& p : info.parameters) names.push_back(p.name);
  return names.empty() ? "it has none" : "it has " + joined(names);
}

void add_outside(const ProfileDomain& d, const Medium<double>& m, double thickness, const std::string& of,
                 std::vector<std::string>& reasons) {
  const double sigma_t_prime = m.sigma_a + m.sigma_s_prime, alpha_prime = m.sigma_s_prime / sigma_t_prime;
  if (m.eta < d.eta_min || m.eta > d.eta_max)
    reasons.push_back(of + "eta " + text(m.eta) + " is not in " + text(d.eta_min) + " .. " + text(d.eta_max));
  if (alpha_prime < d.alpha_prime_min)
    reasons.push_back(of + "alpha' " + text(alpha_prime) + " is below " + text(d.alpha_prime_min));
  if (thickness * sigma_t_prime < d.thickness_min_mfp)
    reasons.push_back(of + "thickness is " + text(thickness * sigma_t_prime) + " transport mean free paths, below " +
                      text(d.thickness_min_mfp));
}

}  // namespace

std::string describe(const ParameterValue& value) {
  if (const double* number = std::get_if<double>(&value)) return text(*number);
  if (const auto* word = std::get_if<std::string>(&value)) return *word;
  if (const auto* layers = std::get_if<std::vector<Layer>>(&value))
    return layers->empty() ? "none" : std::to_string(layers->size()) + " layers";
  return std::to_string(std::get<std::vector<ProfileSample>>(value).size()) + " samples";
}

ProfileParameters ProfileInfo::complete(const ProfileParameters& given) const {
  ProfileParameters completed;
  for (const ProfileParameter& parameter : parameters) {
    const auto it = given.find(parameter.name);
    if (it == given.end() && !parameter.fallback)
      fail(*this, "needs " + parameter.name + ", " + kind_name(parameter.kind) + ": " + parameter.meaning);
    const ParameterValue& value = it == given.end() ? *parameter.fallback : it->second;
    const std::string wrong = it == given.end() ? "" : fault(parameter, value);
    if (!wrong.empty()) fail(*this, parameter.name + ": " + wrong);
    completed[parameter.name] = value;
  }
  for (const auto& [key, value] : given) {
    if (!completed.contains(key)) fail(*this, "no parameter \"" + key + "\"; " + parameter_names(*this));
  }
  return completed;
}

std::unique_ptr<Profile> ProfileInfo::make(const Medium<double>& medium, const ProfileParameters& given) const {
  return build(medium, complete(given));
}

bool ProfileInfo::needs_medium_alone() const {
  return std::ranges::all_of(parameters, [](const ProfileParameter& p) { return p.fallback.has_value(); });
}

std::vector<std::string> ProfileInfo::outside_domain(const Medium<double>& medium,
                                                     const ProfileParameters& given) const {
  std::vector<std::string> reasons;
  if (!depends_on_medium) return reasons;
  const ProfileParameters completed = complete(given);
  const auto thickness = completed.find("thickness_mm"), layers = completed.find("layers");
  add_outside(domain, medium, thickness == completed.end() ? HUGE_VAL : std::get<double>(thickness->second), "",
              reasons);
  if (layers == completed.end()) return reasons;
  const auto& below = std::get<std::vector<Layer>>(layers->second);
  for (std::size_t i = 0; i < below.size(); ++i)
    add_outside(domain, below[i].medium, below[i].thickness, "layer " + std::to_string(i + 2) + ": ", reasons);
  return reasons;
}

}  // namespace opaline
