#include "reports/fit_table.h"

#include "reports/format.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline {
namespace {

using nlohmann::json;

/// Element c of an array, the value itself of a scalar, null of what is missing.
json element(const json& value, std::size_t c) {
  if (!value.is_array()) return value;
  return c < value.size() ? value[c] : json();
}

json member(const json& object, const char* key, std::size_t c) {
  const auto it = object.is_object() ? object.find(key) : object.end();
  return it == object.end() ? json() : element(*it, c);
}

std::optional<double> as_number(const json& value) {
  return value.is_number() ? std::optional(value.get<double>()) : std::nullopt;
}

std::string precise(double value) { return fmt::format("{:.5g}", value); }

/// ci95 is [lo, hi] of a scalar parameter and [[lo, hi], ...] of one with channels.
json interval_of(const json& parameter, std::size_t c) {
  const json ci = parameter.value("ci95", json());
  return ci.is_array() && !ci.empty() && ci[0].is_array() ? element(ci, c) : ci;
}

TableCell interval_cell(const json& parameter, std::size_t c) {
  if (member(parameter, "free", 0) == json(false)) return reason_cell("fixed");
  const json ci = interval_of(parameter, c);
  const auto low = as_number(element(ci, 0)), high = as_number(element(ci, 1));
  if (!ci.is_array() || !low || !high) return reason_cell("unbounded");
  return number_cell(precise(*low) + " to " + precise(*high));
}

TableCell verdict_cell(const json& parameter, std::size_t c) {
  if (member(parameter, "free", 0) == json(false)) return reason_cell("not fitted");
  if (member(parameter, "identifiable", c) == json(true)) return TableCell("identifiable", Tone::good);
  const json reason = member(parameter, "reason", c);
  return TableCell("not identifiable: " + (reason.is_string() ? reason.get<std::string>() : "no reason given"),
                   Tone::bad);
}

void add_comparison(std::vector<TableCell>& row, std::optional<double> value, std::optional<double> truth,
                    std::optional<double> sd) {
  if (!value || !truth || *truth == 0) {
    row.insert(row.end(), 2, reason_cell(truth ? "no value" : "truth unknown"));
    return;
  }
  row.push_back(number_cell(fmt::format("{:+.2f} %", 100 * (*value - *truth) / *truth)));
  row.push_back(sd && *sd > 0 ? number_cell(fmt::format("{:+.1f}", (*value - *truth) / *sd))
                              : reason_cell("no deviation"));
}

std::vector<TableCell> row(const FitResult& fit, const std::string& name, std::size_t c, bool channels) {
  const json& parameter = fit.fit["parameters"][name];
  const auto value = as_number(member(parameter, "value", c));
  const auto truth = fit.truth ? as_number(member(*fit.truth, name.c_str(), c)) : std::nullopt;
  std::vector<TableCell> cells = {channels ? fmt::format("{}[{}]", name, "RGB"[c]) : name};
  cells.push_back(truth ? number_cell(precise(*truth)) : reason_cell("unknown"));
  cells.push_back(value ? number_cell(precise(*value)) : reason_cell("not finite"));
  cells.push_back(interval_cell(parameter, c));
  add_comparison(cells, value, truth, as_number(member(parameter, "sd", c)));
  cells.push_back(verdict_cell(parameter, c));
  return cells;
}

std::string text_or(const json& object, const char* key, const char* fallback) {
  const json value = object.value(key, json());
  return value.is_string() ? value.get<std::string>() : value.is_number() ? number_text(value.get<double>()) : fallback;
}

}  // namespace

Paragraph fit_sentence(const FitResult& fit) {
  const json& f = fit.fit;
  const bool converged = f.value("converged", json()) == json(true);
  const auto relative = as_number(f.value("relative_rmse", json()));
  const json seconds = f.value("seconds", json::object());
  return {fmt::format("Model {}, {} starts, {} iterations, {}; residual {} of the target's RMS, noise {}; {} s.",
                      text_or(f, "model", "unknown"), text_or(f, "starts", "?"), text_or(f, "iterations", "?"),
                      converged ? "converged" : "NOT converged", relative ? relative_text(*relative) : "unknown",
                      text_or(f, "noise_sd", "unknown"), seconds.is_object() ? text_or(seconds, "total", "?") : "?"),
          converged ? Tone::plain : Tone::bad};
}

Table fit_table(const FitResult& fit) {
  Table table{fit.name + ": true against recovered",
              {"parameter", "true", "recovered", "95 % interval", "error", "in sd", "verdict"},
              {},
              false};
  for (const auto& [name, parameter] : fit.fit["parameters"].items()) {
    const json value = parameter.is_object() ? parameter.value("value", json()) : json();
    const std::size_t count = value.is_array() ? std::min<std::size_t>(value.size(), 3) : 1;
    for (std::size_t c = 0; c < count; ++c) table.rows.push_back(row(fit, name, c, value.is_array()));
  }
  return table;
}

std::vector<std::string> fit_notes(const FitResult& fit) {
  std::vector<std::string> notes;
  const json list = fit.fit.value("notes", json::array());
  if (list.is_array())
    for (const json& note : list)
      if (note.is_string()) notes.push_back(note.get<std::string>());
  return notes;
}

}  // namespace opaline
