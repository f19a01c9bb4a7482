#include "validate/record.h"

#include "model/check.h"
#include "render/input_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;
using nlohmann::json;

/// JSON has no infinity: null stands for it.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json numbers(const std::map<std::string, double>& values) {
  Json object = Json::object();
  for (const auto& [name, value] : values) object[name] = number(value);
  return object;
}

Json to_json(const Timing& t) { return {{"median", t.median}, {"min", t.min}, {"runs", t.runs}, {"values", t.values}}; }

Json to_json(const RecordSeconds& s) {
  Json edits = Json::object();
  for (const auto& [edit, cost] : s.edits)
    edits[edit] = {{"total", cost.total}, {"shared", cost.shared}, {"prepare", cost.prepare}, {"render", cost.render}};
  return {{"prepare", to_json(s.prepare)},
          {"render", to_json(s.render)},
          {"load", s.load},
          {"gbuffer", s.gbuffer},
          {"irradiance", s.irradiance},
          {"edits", edits},
          {"harness_overhead", s.harness_overhead}};
}

Json to_json(const RecordReference& r) {
  return {{"settings", r.settings},
          {"certified_relative_error", number(r.certified_relative_error)},
          {"certified_max", number(r.certified_max)},
          {"seconds", r.seconds},
          {"truth_standard_error", number(r.truth_standard_error)},
          {"truth_seconds", r.truth_seconds}};
}

Json to_json(const RecordMachine& m) {
  return {{"cpu", m.cpu},         {"cores", m.cores},       {"gl_renderer", m.gl_renderer},
          {"version", m.version}, {"compiler", m.compiler}, {"program", m.program},
          {"time", m.time}};
}

/// Reads members of one object; a wrong type is an InputError with the place.
class Members {
 public:
  Members(const json& object, const std::string& file, std::string place)
      : object_(object), file_(file), place_(std::move(place)) {
    if (!object.is_object()) throw InputError(file_, place_, "must be an object {...}");
  }

  template <typename T>
  void read(const char* key, T& value) const {
    const auto it = object_.find(key);
    if (it == object_.end()) return;
    try {
      value = it->get<T>();
    } catch (const json::exception& error) {
      throw InputError(file_, place_ + "/" + key, error.what());
    }
  }
  void read(const char* key, double& value) const {
    const auto it = object_.find(key);
    if (it == object_.end()) return;
    if (!it->is_number() && !it->is_null()) throw InputError(file_, place_ + "/" + key, "must be a number or null");
    value = it->is_null() ? std::numeric_limits<double>::infinity() : it->get<double>();
  }
  void read(const char* key, std::map<std::string, double>& values) const {
    if (!object_.contains(key)) return;
    const Members inner = member(key);
    for (const auto& [name, ignored] : inner.object_.items()) inner.read(name.c_str(), values[name]);
  }
  Members member(const std::string& key) const {
    static const json empty = json::object();
    const auto it = object_.find(key);
    return Members(it == object_.end() ? empty : *it, file_, place_ + "/" + key);
  }
  bool has(const char* key) const { return object_.contains(key); }
  std::vector<std::string> keys() const {
    std::vector<std::string> names;
    for (const auto& [name, ignored] : object_.items()) names.push_back(name);
    return names;
  }
  [[noreturn]] void fail(const std::string& problem) const { throw InputError(file_, place_, problem); }

 private:
  const json& object_;
  const std::string& file_;
  std::string place_;
};

Timing read_timing(const Members& in) {
  Timing t;
  in.read("median", t.median);
  in.read("min", t.min);
  in.read("runs", t.runs);
  in.read("values", t.values);
  return t;
}

RecordSeconds read_seconds(const Members& in) {
  RecordSeconds s;
  s.prepare = read_timing(in.member("prepare"));
  s.render = read_timing(in.member("render"));
  in.read("load", s.load);
  in.read("gbuffer", s.gbuffer);
  in.read("irradiance", s.irradiance);
  in.read("harness_overhead", s.harness_overhead);
  const Members edits = in.member("edits");
  for (const std::string& edit : edits.keys()) {
    EditCost& cost = s.edits[edit];
    const Members values = edits.member(edit);
    values.read("total", cost.total);
    values.read("shared", cost.shared);
    values.read("prepare", cost.prepare);
    values.read("render", cost.render);
  }
  return s;
}

RecordReference read_reference(const Members& in) {
  RecordReference r;
  in.read("settings", r.settings);
  in.read("certified_relative_error", r.certified_relative_error);
  in.read("certified_max", r.certified_max);
  in.read("seconds", r.seconds);
  in.read("truth_standard_error", r.truth_standard_error);
  in.read("truth_seconds", r.truth_seconds);
  return r;
}

RecordMachine read_machine(const Members& in) {
  RecordMachine m;
  in.read("cpu", m.cpu);
  in.read("cores", m.cores);
  in.read("gl_renderer", m.gl_renderer);
  in.read("version", m.version);
  in.read("compiler", m.compiler);
  in.read("program", m.program);
  in.read("time", m.time);
  return m;
}

CellStatus read_status(const Members& in) {
  std::string word;
  in.read("status", word);
  for (const CellStatus status : {CellStatus::done, CellStatus::not_applicable, CellStatus::failed})
    if (word == status_name(status)) return status;
  in.fail("\"status\" must be done, not_applicable or failed, but is \"" + word + "\"");
}

void check_format(const Members& in) {
  std::string format;
  int version = 0;
  in.read("format", format);
  in.read("version", version);
  if (format != "opaline-record" || version != 1)
    in.fail("is no record: \"format\" must be \"opaline-record\" and \"version\" 1");
}

}  // namespace

Timing make_timing(std::vector<double> values) {
  OPALINE_CHECK(!values.empty());
  std::vector<double> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  const std::size_t n = sorted.size();
  return {(sorted[(n - 1) / 2] + sorted[n / 2]) / 2, sorted.front(), static_cast<int>(n), std::move(values)};
}

std::string status_name(CellStatus status) {
  return status == CellStatus::done ? "done" : status == CellStatus::failed ? "failed" : "not_applicable";
}

std::string Record::name() const {
  std::string text = fmt::format("{}/{} {}/{}", scene, material, technique, backend);
  for (const auto& [key, value] : settings) text += fmt::format(" {}={}", key, value);
  return text;
}

Json to_json(const Record& r) {
  Json json = {{"format", "opaline-record"},
               {"version", 1},
               {"cell", r.cell},
               {"suite", r.suite},
               {"scene", r.scene},
               {"material", r.material},
               {"technique", r.technique},
               {"backend", r.backend},
               {"settings", r.settings},
               {"film_pixels", r.film_pixels},
               {"samples", r.samples},
               {"light_samples", r.light_samples},
               {"status", status_name(r.status)},
               {"reason", r.reason}};
  json["seconds"] = to_json(r.seconds);
  json["peak_rss_bytes"] = r.peak_rss_bytes;
  json["error"] = numbers(r.error);
  if (r.truth_error) json["truth_error"] = numbers(*r.truth_error);
  json["reference"] = to_json(r.reference);
  json["counters"] = {{"done", r.done}, {"skipped", r.skipped}};
  json["images"] = r.images;
  json["machine"] = to_json(r.machine);
  json["seed"] = r.seed;
  json["command"] = r.command;
  return json;
}

Record record_from_json(const json& document, const std::string& file, const std::string& place) {
  const Members in(document, file, place);
  check_format(in);
  Record r;
  in.read("cell", r.cell);
  in.read("suite", r.suite);
  in.read("scene", r.scene);
  in.read("material", r.material);
  in.read("technique", r.technique);
  in.read("backend", r.backend);
  in.read("settings", r.settings);
  in.read("film_pixels", r.film_pixels);
  in.read("samples", r.samples);
  in.read("light_samples", r.light_samples);
  r.status = read_status(in);
  in.read("reason", r.reason);
  r.seconds = read_seconds(in.member("seconds"));
  in.read("peak_rss_bytes", r.peak_rss_bytes);
  in.read("error", r.error);
  if (in.has("truth_error")) in.read("truth_error", r.truth_error.emplace());
  r.reference = read_reference(in.member("reference"));
  in.member("counters").read("done", r.done);
  in.member("counters").read("skipped", r.skipped);
  in.read("images", r.images);
  r.machine = read_machine(in.member("machine"));
  in.read("seed", r.seed);
  in.read("command", r.command);
  return r;
}

}  // namespace opaline
