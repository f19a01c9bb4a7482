#include "render/techniques/settings.h"

#include "model/check.h"
#include "render/input_error.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace opaline {
namespace {

void validate(const SettingSpec& spec, const std::string& value) {
  const std::string place = "--set " + spec.key;
  if (!spec.choices.empty()) {
    if (std::find(spec.choices.begin(), spec.choices.end(), value) == spec.choices.end())
      throw InputError(place, "", fmt::format("'{}' is not one of {}", value, fmt::join(spec.choices, ", ")));
    return;
  }
  if (spec.text) return;
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !(number >= spec.lo && number <= spec.hi) ||
      (spec.whole && number != std::floor(number)))
    throw InputError(
        place, "",
        fmt::format("'{}' is not a {} from {} to {}", value, spec.whole ? "whole number" : "number", spec.lo, spec.hi));
}

}  // namespace

Settings::Settings(const std::vector<SettingSpec>& specs, const std::map<std::string, std::string>& given) {
  std::vector<std::string> known;
  for (const SettingSpec& spec : specs) {
    known.push_back(spec.key);
    const auto it = given.find(spec.key);
    const std::string& value = values_[spec.key] = it == given.end() ? spec.fallback : it->second;
    validate(spec, value);
  }
  for (const auto& [key, value] : given)
    if (!values_.count(key))
      throw InputError("--set " + key, "", fmt::format("unknown setting; valid: {}", fmt::join(known, ", ")));
}

double Settings::number(const std::string& key) const {
  const std::string& text = word(key);
  double value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

const std::string& Settings::word(const std::string& key) const {
  const auto it = values_.find(key);
  OPALINE_CHECK(it != values_.end());
  return it->second;
}

}  // namespace opaline
