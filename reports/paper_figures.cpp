#include "reports/paper_figures.h"

#include "reports/format.h"
#include "reports/techniques.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace opaline {
namespace {

using nlohmann::json;

const std::map<std::string, json>& documents() {
  static const std::map<std::string, json> all = [] {
    struct File {
      const char *name, *text;
    };
    const File files[] = {
#include "papers.inc"
    };
    std::map<std::string, json> parsed;
    for (const File& file : files) parsed[file.name] = json::parse(file.text);
    return parsed;
  }();
  return all;
}

using NamedSettings = std::map<std::string, std::string>;

/// The settings a SELECT names.
NamedSettings named_settings(const json& select) {
  return select.contains("settings") ? select["settings"].get<NamedSettings>() : NamedSettings();
}

bool agrees(const Record& r, const json& select, const std::string& technique) {
  if (r.status != CellStatus::done || r.technique != select.value("technique", technique)) return false;
  if (r.backend != select.value("backend", r.backend) || r.scene != select.value("scene", r.scene)) return false;
  if (r.material != select.value("material", r.material)) return false;
  for (const auto& [key, value] : named_settings(select))
    if (setting_of(r, key) != value) return false;
  return true;
}

/// Are all settings equal but those that one of the selects names?
bool otherwise_equal(const Record& a, const Record& b, const json& of, const json& over) {
  if (a.technique != b.technique) return true;
  NamedSettings named = named_settings(of), keys = a.settings;
  named.merge(named_settings(over));
  keys.insert(b.settings.begin(), b.settings.end());
  for (const auto& [key, ignored] : keys)
    if (named.count(key) == 0 && setting_of(a, key) != setting_of(b, key)) return false;
  return true;
}

template <typename Map>
std::optional<double> at(const Map& map, const std::string& key) {
  const auto it = map.find(key);
  return it == map.end() ? std::nullopt : std::optional(static_cast<double>(it->second));
}

std::optional<double> value_of(const Record& r, const std::string& quantity) {
  const std::size_t dot = quantity.rfind('.');
  const std::string kind = quantity.substr(0, dot), name = dot == std::string::npos ? "" : quantity.substr(dot + 1);
  if (quantity == "seconds.render") return r.seconds.render.median;
  if (quantity == "seconds.prepare") return r.seconds.prepare.median;
  if (quantity == "frames_per_second") return 1 / r.seconds.render.median;
  if (kind == "error") return at(r.error, name);
  if (kind == "truth_error") return r.truth_error ? at(*r.truth_error, name) : std::nullopt;
  if (kind == "counters.done") return at(r.done, name);
  if (kind == "counters.skipped") return at(r.skipped, name);
  throw std::invalid_argument("a paper's figure names an unknown quantity \"" + quantity + "\"");
}

std::string shown(double value, const std::string& quantity, bool ratio) {
  if (ratio) return number_text(value);
  if (quantity.rfind("seconds.", 0) == 0) return seconds_text(value);
  if (quantity.find("relative_rmse") != std::string::npos) return relative_text(value);
  return number_text(value);
}

TableCell ours_cell(const json& figure, const std::string& technique, const std::vector<Record>& records) {
  if (!figure.contains("ours")) return reason_cell(figure.value("note", "not something the records measure"));
  const json& ours = figure["ours"];
  const auto values = figure_values(ours, technique, records);
  if (values.empty()) return reason_cell("no record of this run has these settings");
  const auto text = [&](double v) { return shown(v, ours["quantity"], ours.contains("over")); };
  if (values.size() == 1) return number_cell(text(values.front()));
  return number_cell(fmt::format("{} (median of {}; {} to {})", text(values[values.size() / 2]), values.size(),
                                 text(values.front()), text(values.back())));
}

}  // namespace

std::vector<double> figure_values(const json& ours, const std::string& technique, const std::vector<Record>& records) {
  const std::string quantity = ours.at("quantity");
  const json of = ours.value("of", json::object()), over = ours.value("over", json());
  std::vector<double> values;
  for (const Record& r : records) {
    const auto value = value_of(r, quantity);
    if (!agrees(r, of, technique) || !value || !std::isfinite(*value)) continue;
    if (over.is_null()) {
      values.push_back(*value);
      continue;
    }
    for (const Record& o : records) {
      const bool same_scene =
          o.scene == r.scene && o.material == r.material && (over.contains("backend") || o.backend == r.backend);
      const auto base = value_of(o, quantity);
      if (same_scene && agrees(o, over, technique) && otherwise_equal(r, o, of, over) && base && *base > 0)
        values.push_back(*value / *base);
    }
  }
  std::sort(values.begin(), values.end());
  return values;
}

std::optional<Table> paper_table(const std::string& technique, const std::vector<Record>& records) {
  const auto it = documents().find(technique);
  if (it == documents().end()) return {};
  const json& document = it->second;
  Table table{technique + ": the paper's figures beside ours. " + document.value("paper", ""),
              {"figure", "in the paper", "place", "ours", "note"},
              {},
              false};
  for (const json& figure : document.at("figures"))
    table.rows.push_back({figure.at("what").get<std::string>(), figure.at("paper").get<std::string>(),
                          figure.at("where").get<std::string>(), ours_cell(figure, technique, records),
                          figure.contains("note") ? TableCell(figure["note"].get<std::string>()) : reason_cell("-")});
  return table;
}

std::vector<std::string> techniques_with_papers() {
  std::vector<std::string> names;
  for (const auto& [name, ignored] : documents()) names.push_back(name);
  return names;
}

const json& paper_document(const std::string& technique) {
  const auto it = documents().find(technique);
  if (it == documents().end()) throw std::invalid_argument("no paper's figures for " + technique);
  return it->second;
}

}  // namespace opaline
