// What a profile of the registry can be told beyond a medium, as data: declared by its row, given by name.
#pragma once

#include "model/conventions.h"

#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>
#include <vector>

namespace opaline {

/// One sample of a measured profile: r [mm] > 0, R_d [1/mm^2] > 0.
struct ProfileSample {
  double r, value;
};

/// One layer of a stack. Its medium's eta is the layer's index over that of the space above the whole stack.
struct Layer {
  Medium<double> medium;
  double thickness = std::numeric_limits<double>::infinity();  ///< [mm]; infinite in the last layer alone
};

/// A number, a word, the samples of a table, or layers from the upper one down.
using ParameterValue = std::variant<double, std::string, std::vector<ProfileSample>, std::vector<Layer>>;

/// Values by name.
using ProfileParameters = std::map<std::string, ParameterValue>;

enum class ParameterKind { number, word, samples, layers };  ///< in the order of ParameterValue

/// A row's declaration of one parameter.
struct ProfileParameter {
  std::string name;
  ParameterKind kind = ParameterKind::number;
  std::string unit = "1";                       ///< "mm", "1", ...; a parameter in mm scales as lengths do
  std::optional<ParameterValue> fallback = {};  ///< none: it must be given
  double low = 0, high = 0;                     ///< range of a number, both ends included
  std::vector<std::string> choices = {};        ///< the words to choose from; empty: the row checks it
  std::string meaning = {};
};

/// A parameter that a row doesn't have, lacks, or whose value isn't valid: names the profile, the parameter and what is
/// valid.
struct ProfileParameterError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

/// The value of a completed set (ProfileInfo::complete).
inline double number_of(const ProfileParameters& p, const std::string& name) { return std::get<double>(p.at(name)); }
inline const std::string& word_of(const ProfileParameters& p, const std::string& name) {
  return std::get<std::string>(p.at(name));
}

/// "thickness_mm = 2" and the like: what a number or a word is, for messages.
std::string describe(const ParameterValue& value);

}  // namespace opaline
