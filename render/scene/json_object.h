// Strict reading of JSON objects: every key is asked for by name, unknown keys are errors, and
// each error names file, place (JSON pointer) and the valid choices.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace opaline {

/// Inclusive or exclusive bounds a number must meet; `describe()` goes into the message.
struct Range {
  double lo = -1e300, hi = 1e300;
  bool lo_open = false, hi_open = false;
  static Range any() { return {}; }
  static Range positive() { return {0, 1e300, true, false}; }
  static Range non_negative() { return {0, 1e300, false, false}; }
  bool contains(double value) const;
  std::string describe() const;
};

/// View of one JSON object. Getters throw InputError on a missing key, a wrong type, a value that
/// is not finite or is out of range. `finish()` throws on keys nobody asked for, listing the
/// known ones. Copies share nothing; the nlohmann::json must outlive the view.
class JsonObject {
 public:
  JsonObject(const nlohmann::json& value, std::string file, std::string pointer);

  bool has(const std::string& key);  ///< also marks the key as known
  double number(const std::string& key, Range range);
  double number_or(const std::string& key, Range range, double fallback);
  int integer(const std::string& key, int lo, int hi);
  int integer_or(const std::string& key, int lo, int hi, int fallback);
  bool boolean_or(const std::string& key, bool fallback);
  std::string text(const std::string& key);
  std::string text_or(const std::string& key, const std::string& fallback);
  std::string choice(const std::string& key, const std::vector<std::string>& choices);
  std::string choice_or(const std::string& key, const std::vector<std::string>& choices, const std::string& fallback);
  glm::dvec3 vec3(const std::string& key, Range range = Range::any());
  glm::dvec3 vec3_or(const std::string& key, Range range, glm::dvec3 fallback);
  /// A number (all three channels) or an array of three.
  glm::dvec3 rgb(const std::string& key, Range range);
  JsonObject object(const std::string& key);
  std::vector<JsonObject> objects(const std::string& key);                          ///< array of objects
  std::vector<std::pair<std::string, JsonObject>> members(const std::string& key);  ///< object of objects
  const nlohmann::json& raw(const std::string& key);                                ///< any value, marks as known
  void finish() const;

  [[noreturn]] void fail(const std::string& key, const std::string& problem) const;
  const std::string& file() const { return file_; }
  const std::string& pointer() const { return pointer_; }

 private:
  const nlohmann::json* find(const std::string& key);
  const nlohmann::json& require(const std::string& key);
  const nlohmann::json* value_;
  std::string file_, pointer_;
  std::vector<std::string> known_;
};

/// Parses a JSON file. InputError with line and column on malformed text or a missing file.
nlohmann::json read_json_file(const std::string& path);

/// Writes text beside its place and renames it there, so that a reader never sees half a file.
void write_text_atomically(const std::string& path, const std::string& text);

}  // namespace opaline
