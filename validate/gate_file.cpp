// Reading of gates (declared in gates.h).
#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"
#include "render/techniques/technique.h"
#include "validate/gates.h"
#include "validate/metrics/metric.h"

#include <algorithm>
#include <filesystem>

namespace opaline {
namespace {

using nlohmann::json;

struct EmbeddedGates {
  const char *name, *text;
};
constexpr EmbeddedGates embedded[] = {
#include "gates.inc"
};

std::map<std::string, std::string> read_settings(JsonObject& in) {
  std::map<std::string, std::string> settings;
  if (!in.has("settings")) return settings;
  const json& raw = in.raw("settings");
  if (!raw.is_object()) in.fail("settings", "must be an object of numbers and words");
  for (const auto& [key, value] : raw.items()) {
    if (!value.is_string() && !value.is_number()) in.fail("settings", "\"" + key + "\" must be a number or a word");
    settings[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return settings;
}

RecordSelection read_selection(JsonObject& in) {
  RecordSelection s;
  s.scene = in.text_or("scene", "");
  s.material = in.text_or("material", "");
  s.technique = in.text_or("technique", "");
  s.backend = in.choice_or("backend", {"cpu", "gpu", "external"}, "");
  s.settings = read_settings(in);
  return s;
}

struct FigureKey {
  const char* key;
  Figure::Kind kind;
};
constexpr FigureKey figure_keys[] = {{"error", Figure::Kind::error},         {"truth_error", Figure::Kind::truth_error},
                                     {"reference", Figure::Kind::reference}, {"counter", Figure::Kind::counter},
                                     {"seconds", Figure::Kind::seconds},     {"count", Figure::Kind::count}};

void check_name(JsonObject& in, const std::string& key, const Figure& figure) {
  const std::string& name = figure.name;
  const auto starts = [&](const char* prefix) { return name.rfind(prefix, 0) == 0; };
  if (figure.kind == Figure::Kind::error || figure.kind == Figure::Kind::truth_error)
    find_metric(name, in.file() + ": " + in.pointer() + "/" + key);
  if (figure.kind == Figure::Kind::reference)
    in.choice(key, {"certified_relative_error", "certified_max", "truth_standard_error"});
  if (figure.kind == Figure::Kind::counter && !starts("done.") && !starts("skipped."))
    in.fail(key, "must be \"done.NAME\" or \"skipped.NAME\", but is \"" + name + "\"");
  const std::vector<std::string> times = {"prepare",    "render",        "edit.camera",
                                          "edit.light", "edit.material", "edit.geometry"};
  if (figure.kind == Figure::Kind::seconds) in.choice(key, times);
  if (figure.kind == Figure::Kind::count) in.choice(key, {"done", "not_applicable", "failed"});
}

Figure read_figure(JsonObject in) {
  Figure figure;
  int kinds = 0;
  for (const FigureKey& row : figure_keys) {
    if (!in.has(row.key)) continue;
    ++kinds;
    figure.kind = row.kind;
    figure.name = in.text(row.key);
    check_name(in, row.key, figure);
  }
  if (kinds != 1)
    throw InputError(
        in.file(), in.pointer(),
        "needs exactly one of \"error\", \"truth_error\", \"reference\", \"counter\", \"seconds\" and \"count\"");
  figure.selection = read_selection(in);
  in.finish();
  return figure;
}

Gate read_gate(JsonObject in) {
  Gate gate;
  gate.name = in.text("name");
  gate.figure = read_figure(in.object("figure"));
  if (in.has("divided_by")) gate.divided_by = read_figure(in.object("divided_by"));
  if (gate.figure.kind == Figure::Kind::seconds && !gate.divided_by)
    in.fail("figure", "an absolute time is of the machine, not of the program; give \"divided_by\" another time");
  if (gate.divided_by &&
      (gate.divided_by->kind == Figure::Kind::seconds) != (gate.figure.kind == Figure::Kind::seconds))
    in.fail("divided_by", "a time can only be divided by a time");
  if (gate.divided_by && (gate.figure.kind == Figure::Kind::count || gate.divided_by->kind == Figure::Kind::count))
    in.fail("divided_by", "a \"count\" is of all records and cannot be divided record by record");
  if (in.has("max") == in.has("min"))
    throw InputError(in.file(), in.pointer(), "needs exactly one of \"max\" and \"min\"");
  gate.upper = in.has("max");
  gate.limit = in.number(gate.upper ? "max" : "min", Range::any());
  in.finish();
  return gate;
}

}  // namespace

GateFile parse_gates(const json& document, const std::string& path) {
  JsonObject in(document, path, "");
  in.choice("format", {"opaline-gates"});
  in.integer("version", 1, 1);
  GateFile file{path, {}};
  for (const JsonObject& gate : in.objects("gates")) file.gates.push_back(read_gate(gate));
  if (file.gates.empty()) in.fail("gates", "must have at least one gate");
  in.finish();
  return file;
}

GateFile find_gates(const std::string& name_or_file) {
  if (std::filesystem::path(name_or_file).extension() == ".json")
    return parse_gates(read_json_file(name_or_file), name_or_file);
  std::vector<std::string> names;
  for (const EmbeddedGates& row : embedded) {
    if (name_or_file == row.name) return parse_gates(json::parse(row.text), name_or_file + ".json");
    names.emplace_back(row.name);
  }
  throw InputError("--gates", "",
                   unknown_choice("set of gates", name_or_file, names) + "; or give a file that ends in .json");
}

}  // namespace opaline
