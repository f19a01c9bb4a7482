#include "reports/gates.h"

#include "reports/format.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

using nlohmann::json;

/// A member as text; empty where it is missing.
std::string text(const json& gate, const char* key) {
  const auto it = gate.find(key);
  if (it == gate.end() || it->is_null()) return "";
  if (it->is_number()) return number_text(it->get<double>());
  return it->is_string() ? it->get<std::string>() : it->dump();
}

TableCell or_reason(const std::string& words, const char* reason) {
  return words.empty() ? reason_cell(reason) : TableCell(words);
}

std::string limit(const json& gate) {
  const bool upper = gate.contains("max");
  return (upper ? "at most " : "at least ") + text(gate, upper ? "max" : "min");
}

TableCell verdict(const std::string& outcome) {
  if (outcome == "passed") return TableCell("holds", Tone::good);
  if (outcome == "skipped") return TableCell("skipped", Tone::muted);
  return TableCell("fell short", Tone::bad);
}

/// Gates of one outcome; what is neither passed nor skipped has failed.
std::ptrdiff_t count(const json& gates, const char* outcome) {
  return std::count_if(gates.begin(), gates.end(), [&](const json& g) { return text(g, "outcome") == outcome; });
}

}  // namespace

Paragraph gates_verdict(const std::optional<json>& gates) {
  if (!gates) return {"No gates.json: no gate was checked.", Tone::muted};
  const json& all = gates->at("gates");
  const auto passed = count(all, "passed"), skipped = count(all, "skipped");
  const auto failed = static_cast<std::ptrdiff_t>(all.size()) - passed - skipped;
  const std::string also = skipped > 0 ? fmt::format(" {} could not be checked.", skipped) : "";
  if (failed == 0) return {fmt::format("{} of {} gates hold.{}", passed, all.size(), also), Tone::good};
  return {fmt::format("{} of {} gates fell short.{}", failed, all.size(), also), Tone::bad};
}

Table gates_table(const json& gates) {
  std::vector<json> rows = gates.at("gates");
  std::stable_partition(rows.begin(), rows.end(), [](const json& g) { return text(g, "outcome") == "failed"; });
  Table table{"Gates", {"gate", "verdict", "worst value", "limit", "where", "message"}, {}, rows.size() > 12};
  for (const json& gate : rows) {
    const std::string value = text(gate, "value");
    table.rows.push_back({or_reason(text(gate, "name"), "unnamed"), verdict(text(gate, "outcome")),
                          value.empty() ? reason_cell("not finite") : number_cell(value), TableCell(limit(gate)),
                          or_reason(text(gate, "where"), "no record"), or_reason(text(gate, "message"), "-")});
  }
  return table;
}

}  // namespace opaline
