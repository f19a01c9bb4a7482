// What a person reads in a minute: what was run and where, who is best, the gates, what failed and why.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/gates.h"
#include "reports/machines.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace opaline {
namespace {

constexpr std::array<double, 3> limits = {0.05, 0.01, 0.001};

std::size_t count_of(const std::vector<Record>& records, CellStatus status) {
  return static_cast<std::size_t>(
      std::count_if(records.begin(), records.end(), [&](const Record& r) { return r.status == status; }));
}

std::set<std::string> suites(const std::vector<Record>& records) {
  std::set<std::string> names;
  for (const Record& r : records) names.insert(r.suite);
  return names;
}

std::string what_was_run(const ReportData& data, std::size_t scenes) {
  const auto names = suites(data.records);
  return fmt::format(
      "Suite{} {}: {} cells of {} techniques over {} scenes with their materials; {} measured, {} not applicable, {} "
      "failed.",
      names.size() == 1 ? "" : "s", fmt::join(names, ", "), data.records.size(), technique_names(data.records).size(),
      scenes, count_of(data.records, CellStatus::done), count_of(data.records, CellStatus::not_applicable),
      count_of(data.records, CellStatus::failed));
}

TableCell best_cell(const Record* r, const std::string& reason) {
  if (r == nullptr) return reason_cell(reason);
  TableCell cell(
      fmt::format("{}: {} in {}", contender(*r), relative_text(*error_of(*r)), seconds_text(r->seconds.render.median)));
  cell.link = record_anchor(*r);
  return cell;
}

std::string certified(const SceneGroup& group) {
  for (const Record* r : group.records)
    if (r->status == CellStatus::done && r->reference.certified_relative_error > 0)
      return relative_text(r->reference.certified_relative_error);
  return "not stated";
}

Table best_table(const std::vector<SceneGroup>& groups) {
  Table table{
      "Best technique of each scene (error, time of a frame)",
      {"scene, material", "cheapest within 5 %", "cheapest within 1 %", "most accurate", "reference certified to"},
      {},
      groups.size() > 12};
  for (const SceneGroup& g : groups)
    table.rows.push_back({g.title(), best_cell(cheapest_within(g.records, 0.05), "nothing is within 5 %"),
                          best_cell(cheapest_within(g.records, 0.01), "nothing is within 1 %"),
                          best_cell(most_accurate(g.records), "nothing was measured"), number_cell(certified(g))});
  return table;
}

/// How often each contender is the cheapest within a limit.
Table wins_table(const std::vector<SceneGroup>& groups) {
  std::map<std::string, std::array<int, 3>> wins;
  for (const SceneGroup& g : groups) {
    for (const Record* r : g.records)
      if (is_ranked(*r)) wins[contender(*r)];
    for (std::size_t i = 0; i < limits.size(); ++i)
      if (const Record* best = cheapest_within(g.records, limits[i])) ++wins[contender(*best)][i];
  }
  Table table{fmt::format("In how many of {} scenes a technique is the cheapest within an error", groups.size()),
              {"technique, backend", "5 %", "1 %", "0.1 %"},
              {},
              false};
  for (const auto& [name, counts] : wins) {
    std::vector<TableCell> row = {name};
    for (const int n : counts) row.push_back(number_cell(std::to_string(n)));
    table.rows.push_back(row);
  }
  return table;
}

/// Cells without a measurement, by technique and reason.
void add_reasons(Blocks& blocks, const ReportData& data, CellStatus status, const char* caption) {
  std::map<std::pair<std::string, std::string>, std::set<std::string>> scenes;
  std::map<std::pair<std::string, std::string>, std::size_t> cells;
  for (const Record& r : data.records) {
    if (r.status != status) continue;
    scenes[{contender(r), r.reason}].insert(r.scene);
    ++cells[{contender(r), r.reason}];
  }
  if (cells.empty()) return;
  Table table{caption, {"technique, backend", "reason", "cells", "scenes"}, {}, cells.size() > 8};
  for (const auto& [key, count] : cells) {
    const auto& names = scenes[key];
    table.rows.push_back({key.first, reason_cell(key.second), number_cell(std::to_string(count)),
                          fmt::format("{}", fmt::join(names, ", "))});
  }
  blocks.push_back(table);
}

/// What this report does not contain.
std::vector<std::string> left_out(const ReportData& data) {
  std::vector<std::string> items;
  if (data.cut)
    items.push_back(
        "The last line of records.jsonl is unfinished: the run was interrupted there, and that cell is not here.");
  if (data.superseded > 0)
    items.push_back(
        fmt::format("{} earlier measurements of cells that were measured again are not shown.", data.superseded));
  if (!data.stress) items.push_back("There is no stress.json: the numerical stress table is empty.");
  if (data.fits.empty()) items.push_back("There are no fits.");
  return items;
}

Blocks write(const ReportData& data) {
  Blocks blocks;
  const auto groups = scene_groups(data.records);
  if (!data.records.empty()) blocks.push_back(Paragraph{what_was_run(data, groups.size())});
  for (const std::string& machine : machine_lines(data.records)) blocks.push_back(Paragraph{machine, Tone::muted});
  blocks.push_back(gates_verdict(data.gates));
  if (data.gates) blocks.push_back(gates_table(*data.gates));
  if (!groups.empty()) {
    blocks.push_back(best_table(groups));
    blocks.push_back(wins_table(groups));
  }
  add_reasons(blocks, data, CellStatus::failed, "Failed cells");
  add_reasons(blocks, data, CellStatus::not_applicable, "Cells that are not applicable");
  if (const auto items = left_out(data); !items.empty()) blocks.push_back(List{items});
  return blocks;
}

}  // namespace

Section summary_section() { return {"summary", "Summary", write}; }

}  // namespace opaline
