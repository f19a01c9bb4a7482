#include "reports/gates.h"

#include "reports/format.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

using nlohmann::json;

bool passed(const json& gate) {
  const auto it = gate.find("passed");
  return it != gate.end() && it->is_boolean() && it->get<bool>();
}

/// A member as text; "not stated" where it is missing.
std::string text(const json& gate, const char* key) {
  const auto it = gate.find(key);
  if (it == gate.end() || it->is_null()) return "not stated";
  if (it->is_number()) return number_text(it->get<double>());
  return it->is_string() ? it->get<std::string>() : it->dump();
}

}  // namespace

Paragraph gates_verdict(const std::optional<json>& gates) {
  if (!gates) return {"No gates.json: no gate was checked.", Tone::muted};
  const json& all = gates->at("gates");
  const auto failed = std::count_if(all.begin(), all.end(), [](const json& g) { return !passed(g); });
  if (failed == 0) return {fmt::format("All {} gates hold.", all.size()), Tone::good};
  return {fmt::format("{} of {} gates fell short.", failed, all.size()), Tone::bad};
}

Table gates_table(const json& gates) {
  std::vector<json> rows = gates.at("gates");
  std::stable_partition(rows.begin(), rows.end(), [](const json& g) { return !passed(g); });
  Table table{"Gates", {"gate", "value", "limit", "verdict", "reason"}, {}, rows.size() > 12};
  for (const json& gate : rows) {
    const bool good = passed(gate);
    const std::string reason = text(gate, "reason");
    table.rows.push_back({text(gate, "name"), number_cell(text(gate, "value")), number_cell(text(gate, "limit")),
                          Cell(good ? "holds" : "fell short", good ? Tone::good : Tone::bad),
                          reason == "not stated" || reason.empty() ? reason_cell("-") : Cell(reason)});
  }
  return table;
}

}  // namespace opaline
