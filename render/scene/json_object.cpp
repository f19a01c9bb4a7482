#include "render/scene/json_object.h"

#include "render/choices.h"
#include "render/input_error.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace opaline {
namespace {

using nlohmann::json;

/// RFC 6901: '~' and '/' inside a key.
std::string escape(const std::string& key) {
  std::string escaped;
  for (char c : key) escaped += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
  return escaped;
}

std::string brief(const json& value) {
  if (value.is_number_float() && !std::isfinite(value.get<double>())) return "not finite";
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() <= 60 ? text : text.substr(0, 57) + "...";
}

std::string short_number(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

double checked_number(const json& value, const std::string& file, const std::string& place, const Range& range) {
  const bool good = value.is_number() && range.contains(value.get<double>());
  if (!good) throw InputError(file, place, "must be " + range.describe() + ", but is " + brief(value));
  return value.get<double>();
}

glm::dvec3 checked_vec3(const json& value, const std::string& file, const std::string& place, const Range& range) {
  if (!value.is_array() || value.size() != 3) {
    throw InputError(file, place, "must be an array of three numbers, but is " + brief(value));
  }
  glm::dvec3 v;
  for (int i = 0; i < 3; ++i) v[i] = checked_number(value[i], file, place + "/" + std::to_string(i), range);
  return v;
}

}  // namespace

bool Range::contains(double value) const {
  if (!std::isfinite(value)) return false;
  return (lo_open ? value > lo : value >= lo) && (hi_open ? value < hi : value <= hi);
}

std::string Range::describe() const {
  const bool below = lo > -1e300, above = hi < 1e300;
  std::string text = "a finite number";
  if (below) text = std::string("a number ") + (lo_open ? "> " : ">= ") + short_number(lo);
  if (above) text += std::string(below ? " and " : " ") + (hi_open ? "< " : "<= ") + short_number(hi);
  return text;
}

JsonObject::JsonObject(const json& value, std::string file, std::string pointer)
    : value_(&value), file_(std::move(file)), pointer_(std::move(pointer)) {
  if (!value.is_object()) throw InputError(file_, pointer_, "must be an object {...}, but is " + brief(value));
}

const json* JsonObject::find(const std::string& key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.push_back(key);
  const auto it = value_->find(key);
  return it == value_->end() ? nullptr : &*it;
}

const json& JsonObject::require(const std::string& key) {
  if (const json* value = find(key)) return *value;
  std::vector<std::string> given;
  for (const auto& [name, value] : value_->items()) given.push_back(name);
  const std::string misspelt = nearest_choice(key, given);
  const bool is_typo = !misspelt.empty() && std::find(known_.begin(), known_.end(), misspelt) == known_.end();
  const std::string question = is_typo ? "; did you mean it by \"" + misspelt + "\"?" : "";
  throw InputError(file_, pointer_, "the key \"" + key + "\" is missing" + question);
}

bool JsonObject::has(const std::string& key) { return find(key) != nullptr; }

double JsonObject::number(const std::string& key, Range range) {
  return checked_number(require(key), file_, pointer_ + "/" + escape(key), range);
}

double JsonObject::number_or(const std::string& key, Range range, double fallback) {
  return has(key) ? number(key, range) : fallback;
}

int JsonObject::integer(const std::string& key, int lo, int hi) {
  const json& value = require(key);
  const Range range{static_cast<double>(lo), static_cast<double>(hi)};
  const double number = value.is_number() ? value.get<double>() : 0.5;
  if (!range.contains(number) || number != std::floor(number)) {
    fail(key,
         "must be an integer from " + std::to_string(lo) + " to " + std::to_string(hi) + ", but is " + brief(value));
  }
  return static_cast<int>(number);
}

int JsonObject::integer_or(const std::string& key, int lo, int hi, int fallback) {
  return has(key) ? integer(key, lo, hi) : fallback;
}

bool JsonObject::boolean_or(const std::string& key, bool fallback) {
  const json* value = find(key);
  if (value == nullptr) return fallback;
  if (!value->is_boolean()) fail(key, "must be true or false, but is " + brief(*value));
  return value->get<bool>();
}

std::string JsonObject::text(const std::string& key) {
  const json& value = require(key);
  if (!value.is_string()) fail(key, "must be a text in quotes, but is " + brief(value));
  return value.get<std::string>();
}

std::string JsonObject::text_or(const std::string& key, const std::string& fallback) {
  return has(key) ? text(key) : fallback;
}

std::string JsonObject::choice(const std::string& key, const std::vector<std::string>& choices) {
  const std::string given = text(key);
  if (std::find(choices.begin(), choices.end(), given) == choices.end()) {
    fail(key, unknown_choice("choice", given, choices));
  }
  return given;
}

std::string JsonObject::choice_or(const std::string& key, const std::vector<std::string>& choices,
                                  const std::string& fallback) {
  return has(key) ? choice(key, choices) : fallback;
}

glm::dvec3 JsonObject::vec3(const std::string& key, Range range) {
  return checked_vec3(require(key), file_, pointer_ + "/" + escape(key), range);
}

glm::dvec3 JsonObject::vec3_or(const std::string& key, Range range, glm::dvec3 fallback) {
  return has(key) ? vec3(key, range) : fallback;
}

glm::dvec3 JsonObject::rgb(const std::string& key, Range range) {
  return require(key).is_number() ? glm::dvec3(number(key, range)) : vec3(key, range);
}

JsonObject JsonObject::object(const std::string& key) {
  return JsonObject(require(key), file_, pointer_ + "/" + escape(key));
}

std::vector<JsonObject> JsonObject::objects(const std::string& key) {
  const json& value = require(key);
  if (!value.is_array()) fail(key, "must be an array [...] of objects, but is " + brief(value));
  std::vector<JsonObject> elements;
  for (std::size_t i = 0; i < value.size(); ++i) {
    elements.emplace_back(value[i], file_, pointer_ + "/" + escape(key) + "/" + std::to_string(i));
  }
  return elements;
}

std::vector<std::pair<std::string, JsonObject>> JsonObject::members(const std::string& key) {
  const JsonObject parent = object(key);
  std::vector<std::pair<std::string, JsonObject>> result;
  for (const auto& [name, value] : parent.value_->items()) {
    result.emplace_back(name, JsonObject(value, file_, parent.pointer_ + "/" + escape(name)));
  }
  return result;
}

const json& JsonObject::raw(const std::string& key) { return require(key); }

void JsonObject::finish() const {
  for (const auto& [name, value] : value_->items()) {
    if (std::find(known_.begin(), known_.end(), name) == known_.end()) {
      throw InputError(file_, pointer_, unknown_choice("key", name, known_));
    }
  }
}

void JsonObject::fail(const std::string& key, const std::string& problem) const {
  throw InputError(file_, pointer_ + "/" + escape(key), problem);
}

}  // namespace opaline
