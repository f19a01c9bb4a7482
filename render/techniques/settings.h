// Settings of a technique: declared with default, meaning and valid values; given as key=value.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace opaline {

struct SettingSpec {
  std::string key, fallback, meaning;
  std::vector<std::string> choices;  ///< a word out of these; empty: a number in [lo, hi]
  double lo = 0, hi = 0;
  bool whole = false;  ///< the number must be an integer
  bool text = false;   ///< any text, instead of a number: a file's name
};

/// Every declared key has a valid value.
class Settings {
 public:
  /// given: key -> text from the user. Throws InputError ("--set key") for an unknown key or a value
  /// that is not valid, naming the valid ones.
  Settings(const std::vector<SettingSpec>& specs, const std::map<std::string, std::string>& given);

  double number(const std::string& key) const;
  const std::string& word(const std::string& key) const;
  const std::map<std::string, std::string>& values() const { return values_; }

 private:
  std::map<std::string, std::string> values_;
};

}  // namespace opaline
