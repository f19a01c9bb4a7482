#include "model/cmd/profile_parameters.h"

#include "model/cmd/medium_options.h"
#include "model/profiles/tabulated_profile.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace opaline {
namespace {

double number(const std::string& text, const std::string& option) {
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  require_argument(used == text.size() && !text.empty(), fmt::format("{}: \"{}\" is not a number", option, text));
  return value;
}

std::vector<ProfileSample> read_samples(const std::string& file) {
  std::ifstream in(file);
  require_argument(in.good(), fmt::format("--set samples: cannot read {}", file));
  std::ostringstream text;
  text << in.rdbuf();
  try {
    return parse_profile_csv(text.str());
  } catch (const ProfileTableError& e) {
    throw std::invalid_argument(e.line > 0 ? fmt::format("{}: line {}: {}", file, e.line, e.what())
                                           : fmt::format("{}: {}", file, e.what()));
  }
}

ParameterValue value_of(const ProfileParameter& parameter, const std::string& text) {
  switch (parameter.kind) {
    case ParameterKind::number:
      return number(text, "--set " + parameter.name);
    case ParameterKind::word:
      return text;
    case ParameterKind::samples:
      return read_samples(text);
    case ParameterKind::layers:
      break;
  }
  throw std::invalid_argument(fmt::format("--set {}: give the stack as --layer, once for each layer", parameter.name));
}

std::string declared_names(const std::vector<const ProfileInfo*>& models) {
  std::vector<std::string> names;
  for (const ProfileInfo* model : models) {
    for (const ProfileParameter& p : model->parameters) {
      if (std::ranges::find(names, p.name) == names.end()) names.push_back(p.name);
    }
  }
  return names.empty() ? "they have none" : fmt::format("they have {}", fmt::join(names, ", "));
}

}  // namespace

std::vector<const ProfileInfo*> models_of(const std::vector<std::string>& names) {
  std::vector<const ProfileInfo*> models;
  for (const std::string& name : names) {
    const ProfileInfo* info = find_profile(name);
    require_argument(info != nullptr,
                     fmt::format("--model: no profile \"{}\"; choose from {}", name, fmt::join(profile_names(), ", ")));
    require_argument(std::ranges::find(models, info) == models.end(), fmt::format("--model: {} is named twice", name));
    models.push_back(info);
  }
  return models;
}

std::vector<ProfileParameters> parameters_of(const std::vector<const ProfileInfo*>& models,
                                             const std::vector<std::string>& settings) {
  std::vector<ProfileParameters> parameters(models.size());
  for (const std::string& setting : settings) {
    const std::size_t equals = setting.find('=');
    require_argument(equals != setting.npos, fmt::format("--set: \"{}\" is not key=value", setting));
    const std::string key = setting.substr(0, equals), text = setting.substr(equals + 1);
    bool known = false;
    for (std::size_t i = 0; i < models.size(); ++i) {
      const auto p = std::ranges::find(models[i]->parameters, key, &ProfileParameter::name);
      if (p == models[i]->parameters.end()) continue;
      parameters[i][key] = value_of(*p, text);
      known = true;
    }
    require_argument(known, fmt::format("--set: no model here has \"{}\"; {}", key, declared_names(models)));
  }
  return parameters;
}

std::vector<Layer> parse_layers(const std::vector<std::string>& texts) {
  std::vector<Layer> layers;
  for (const std::string& text : texts) {
    std::vector<double> values;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, ',');) values.push_back(number(part, "--layer"));
    require_argument(values.size() == 4,
                     fmt::format("--layer: \"{}\" is not sigma_a,sigma_s_prime,eta,thickness_mm, as 0.01,1,1.4,0.5 "
                                 "(thickness inf for a half space)",
                                 text));
    layers.push_back({{values[0], values[1], values[2]}, values[3]});
  }
  return layers;
}

void add_layers(const std::vector<const ProfileInfo*>& models, const std::vector<Layer>& stack,
                std::vector<ProfileParameters>& parameters) {
  for (std::size_t i = 0; i < models.size(); ++i) {
    for (const ProfileParameter& p : models[i]->parameters) {
      if (p.name == "thickness_mm") parameters[i][p.name] = stack.front().thickness;
      if (p.kind == ParameterKind::layers) parameters[i][p.name] = std::vector<Layer>(stack.begin() + 1, stack.end());
    }
  }
}

}  // namespace opaline
