// The numerical stress table: `opaline stress --json`.
#include "reports/format.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

using nlohmann::json;

std::optional<double> number(const json& row, const char* key) {
  const auto it = row.find(key);
  return it != row.end() && it->is_number() ? std::optional(it->get<double>()) : std::nullopt;
}

bool passed(const json& row) {
  const auto it = row.find("passed");
  return it != row.end() && it->is_boolean() && it->get<bool>();
}

/// Of {"value", "condition", "at"}.
std::optional<double> worst(const json& row, const char* key) {
  const auto it = row.find(key);
  return it != row.end() && it->is_object() && number(row, "points").value_or(0) > 0 ? number(*it, "value")
                                                                                     : std::nullopt;
}

/// How close the worst case is to its limit; broken rows come first whatever they compare.
double urgency(const json& row) {
  if (!passed(row)) return 1e300;
  const double limit = number(row, "limit").value_or(0);
  return limit > 0 ? worst(row, "worst_ulp_per_condition").value_or(0) / limit : 0;
}

std::string place(const json& row) {
  const auto it = row.find("worst_ulp_per_condition");
  const json at = it != row.end() && it->is_object() ? it->value("at", json::array()) : json::array();
  const json inputs = row.value("inputs", json::array());
  std::string text;
  for (std::size_t i = 0; i < at.size() && i < inputs.size(); ++i)
    if (at[i].is_number() && inputs[i].is_string())
      text += fmt::format("{}{} = {:.6g}", text.empty() ? "" : ", ", inputs[i].get<std::string>(), at[i].get<double>());
  return text;
}

TableCell value_cell(std::optional<double> value) {
  return value ? number_cell(number_text(*value)) : reason_cell("not compared");
}

TableCell count_cell(const json& row, const char* key) {
  const double count = number(row, key).value_or(0);
  TableCell cell = number_cell(count_text(static_cast<std::uint64_t>(count)));
  return cell;
}

std::vector<TableCell> cells(const json& row) {
  const json name = row.value("name", json("unnamed"));
  const bool derivative = row.value("derivative", json(false)) == json(true);
  std::vector<TableCell> line = {(derivative ? "d " : "") + (name.is_string() ? name.get<std::string>() : name.dump())};
  line.push_back(count_cell(row, "points"));
  line.push_back(value_cell(worst(row, "worst_ulp_per_condition")));
  line.push_back(value_cell(number(row, "limit")));
  line.push_back(value_cell(worst(row, "worst_ulp")));
  for (const char* key : {"checked", "nan", "infinite", "negative", "not_monotone"})
    line.push_back(count_cell(row, key));
  line.push_back(passed(row) ? TableCell("ok", Tone::good) : TableCell("past a limit", Tone::bad));
  line.push_back(place(row).empty() ? reason_cell("not compared") : TableCell(place(row)));
  return line;
}

Blocks write(const ReportData& data) {
  if (!data.stress)
    return {Paragraph{"There is no stress.json: `opaline stress --json > DIR/stress.json` makes it.", Tone::muted}};
  std::vector<json> rows = data.stress->at("functions");
  std::stable_sort(rows.begin(), rows.end(), [](const json& a, const json& b) { return urgency(a) > urgency(b); });
  const auto broken = std::count_if(rows.begin(), rows.end(), [](const json& r) { return !passed(r); });
  Table table{"Worst cases, closest to their limit first",
              {"function (d: its derivatives)", "points", "ULP / (1 + k)", "limit", "worst ULP", "checked", "NaN",
               "infinite", "negative", "not monotone", "verdict", "worst at"},
              {},
              rows.size() > 12};
  for (const json& row : rows) table.rows.push_back(cells(row));
  return {Paragraph{fmt::format(
              "{} functions over their whole domains, against 100-digit arithmetic. k is the condition number there: "
              "ULP / (1 + k) is the rounding error the formula itself is to blame for.",
              rows.size())},
          broken == 0 ? Paragraph{"Every function is within its limit, and none gave NaN, infinity, a negative or a "
                                  "non-monotone value.",
                                  Tone::good}
                      : Paragraph{fmt::format("{} of {} functions broke a limit.", broken, rows.size()), Tone::bad},
          table};
}

}  // namespace

Section stress_section() { return {"stress", "Numerical stress", write}; }

}  // namespace opaline
