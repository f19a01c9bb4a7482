#include "validate/gates.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// A value of one record, or of two.
struct Value {
  double value = 0;
  std::string where;
};

std::optional<double> found(const std::map<std::string, double>& values, const std::string& name) {
  const auto it = values.find(name);
  if (it == values.end()) return std::nullopt;
  return name == "mean_error" ? std::abs(it->second) : it->second;
}

std::optional<double> reference(const RecordReference& r, const std::string& name) {
  const double value = name == "certified_max"              ? r.certified_max
                       : name == "certified_relative_error" ? r.certified_relative_error
                                                            : r.truth_standard_error;
  return value > 0 ? std::optional(value) : std::nullopt;  // 0: there was none
}

std::optional<double> counter(const Record& r, const std::string& name) {
  const bool done = name.rfind("done.", 0) == 0;
  const auto& counts = done ? r.done : r.skipped;
  const auto it = counts.find(name.substr(name.find('.') + 1));
  return it == counts.end() ? std::nullopt : std::optional(static_cast<double>(it->second));
}

std::optional<double> seconds(const Record& r, const std::string& name) {
  if (name == "prepare") return r.seconds.prepare.min;
  if (name == "render") return r.seconds.render.min;
  const auto it = r.seconds.edits.find(name.substr(name.find('.') + 1));
  return it == r.seconds.edits.end() ? std::nullopt : std::optional(it->second.total);
}

std::optional<double> value_of(const Figure& figure, const Record& r) {
  switch (figure.kind) {
    case Figure::Kind::error:
      return found(r.error, figure.name);
    case Figure::Kind::truth_error:
      return r.truth_error ? found(*r.truth_error, figure.name) : std::nullopt;
    case Figure::Kind::reference:
      return reference(r.reference, figure.name);
    case Figure::Kind::counter:
      return counter(r, figure.name);
    case Figure::Kind::seconds:
      return seconds(r, figure.name);
    case Figure::Kind::count:
      return status_name(r.status) == figure.name ? 1 : 0;
  }
  return {};
}

/// The values of the done records that are selected and have one.
std::vector<std::pair<const Record*, double>> values_of(const Figure& figure, const std::vector<Record>& records) {
  std::vector<std::pair<const Record*, double>> values;
  for (const Record& r : records) {
    if (r.status != CellStatus::done || !selects(figure.selection, r)) continue;
    if (const std::optional<double> value = value_of(figure, r)) values.emplace_back(&r, *value);
  }
  return values;
}

std::vector<Value> counted(const Gate& gate, const std::vector<Record>& records) {
  Value sum;
  std::size_t selected = 0;
  for (const Record& r : records) {
    if (!selects(gate.figure.selection, r)) continue;
    ++selected;
    if (*value_of(gate.figure, r) == 0) continue;
    sum.value += 1;
    if (sum.where.empty()) sum.where = r.name() + (r.reason.empty() ? "" : ": " + r.reason);
  }
  return selected > 0 ? std::vector{sum} : std::vector<Value>{};
}

/// The same scene and material, and of the same technique the same settings, unless the divisor names its own.
bool is_divisor(const Record& above, const Record& below, const Figure& divided_by) {
  return above.scene == below.scene && above.material == below.material &&
         (above.technique != below.technique || above.settings == below.settings ||
          !divided_by.selection.settings.empty());
}

std::vector<Value> values_of(const Gate& gate, const std::vector<Record>& records) {
  if (gate.figure.kind == Figure::Kind::count) return counted(gate, records);
  std::vector<Value> values;
  for (const auto& [above, value] : values_of(gate.figure, records)) {
    if (!gate.divided_by) {
      values.push_back({value, above->name()});
      continue;
    }
    for (const auto& [below, divisor] : values_of(*gate.divided_by, records))
      if (is_divisor(*above, *below, *gate.divided_by))
        values.push_back({value / divisor, above->name() + " by " + below->name()});
  }
  return values;
}

bool any_not_applicable(const RecordSelection& selection, const std::vector<Record>& records) {
  bool any = false;
  for (const Record& r : records) {
    if (!selects(selection, r)) continue;
    if (r.status != CellStatus::not_applicable) return false;
    any = true;
  }
  return any;
}

/// Worst first: what isn't finite, then what is furthest beyond the limit's side.
const Value& worst(const std::vector<Value>& values, bool upper) {
  return *std::max_element(values.begin(), values.end(), [upper](const Value& a, const Value& b) {
    if (std::isfinite(a.value) != std::isfinite(b.value)) return std::isfinite(a.value);
    return upper ? a.value < b.value : a.value > b.value;
  });
}

GateResult without_values(GateResult result, const Gate& gate, const std::vector<Record>& records) {
  const bool skipped = any_not_applicable(gate.figure.selection, records) ||
                       (gate.divided_by && any_not_applicable(gate.divided_by->selection, records));
  result.outcome = skipped ? GateResult::Outcome::skipped : GateResult::Outcome::failed;
  result.message = skipped ? "all records it is about are not applicable" : "no record has this figure";
  return result;
}

GateResult check(const Gate& gate, const std::vector<Record>& records) {
  GateResult result{gate.name, GateResult::Outcome::passed, 0, gate.limit, gate.upper, "", ""};
  const std::vector<Value> values = values_of(gate, records);
  if (values.empty()) return without_values(result, gate, records);
  const Value& value = worst(values, gate.upper);
  result.value = value.value;
  result.where = value.where;
  const bool holds = std::isfinite(value.value) && (gate.upper ? value.value <= gate.limit : value.value >= gate.limit);
  if (holds) return result;
  result.outcome = GateResult::Outcome::failed;
  result.message = fmt::format("{:.6g} is not {} {:.6g}", value.value, gate.upper ? "<=" : ">=", gate.limit);
  return result;
}

const char* outcome_name(GateResult::Outcome outcome) {
  return outcome == GateResult::Outcome::passed   ? "passed"
         : outcome == GateResult::Outcome::failed ? "failed"
                                                  : "skipped";
}

}  // namespace

bool selects(const RecordSelection& s, const Record& r) {
  const auto agrees = [](const std::string& wanted, const std::string& given) {
    return wanted.empty() || wanted == given;
  };
  if (!agrees(s.scene, r.scene) || !agrees(s.material, r.material) || !agrees(s.technique, r.technique) ||
      !agrees(s.backend, r.backend))
    return false;
  return std::all_of(s.settings.begin(), s.settings.end(), [&](const auto& setting) {
    const auto it = r.settings.find(setting.first);
    return it != r.settings.end() && it->second == setting.second;
  });
}

std::vector<GateResult> check_gates(const std::vector<Gate>& gates, const std::vector<Record>& records) {
  std::vector<GateResult> results;
  for (const Gate& gate : gates) results.push_back(check(gate, records));
  return results;
}

nlohmann::ordered_json to_json(const std::vector<GateResult>& results) {
  using Json = nlohmann::ordered_json;
  Json rows = Json::array();
  for (const GateResult& r : results)
    rows.push_back({{"name", r.name},
                    {"outcome", outcome_name(r.outcome)},
                    {"value", std::isfinite(r.value) ? Json(r.value) : Json()},
                    {r.upper ? "max" : "min", r.limit},
                    {"where", r.where},
                    {"message", r.message}});
  return {{"format", "opaline-gate-results"}, {"version", 1}, {"gates", rows}};
}

}  // namespace opaline
