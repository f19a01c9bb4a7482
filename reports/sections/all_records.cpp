// Every number with the machine it comes from and the command that makes it again.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/machines.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

/// The anchor that other sections link to stands on the first cell.
TableCell name_cell(const Record& r) {
  TableCell cell(r.scene + ", " + r.material);
  cell.id = record_anchor(r);
  return cell;
}

std::vector<TableCell> measured(const Record& r) {
  const auto metric = [&](const char* name) {
    const auto value = error_of(r, name);
    return value ? number_cell(number_text(*value)) : reason_cell("not computed");
  };
  const TableCell truth =
      truth_error_of(r) ? number_cell(relative_text(*truth_error_of(r))) : reason_cell("not asked for");
  return {error_of(r) ? number_cell(relative_text(*error_of(r)))
                      : reason_cell(r.reason.empty() ? "no reference" : r.reason),
          truth,
          metric("flip"),
          number_cell(seconds_text(r.seconds.prepare.median)),
          number_cell(fmt::format("{} (least {} of {})", seconds_text(r.seconds.render.median),
                                  seconds_text(r.seconds.render.min), r.seconds.render.runs)),
          number_cell(bytes_text(r.peak_rss_bytes))};
}

std::vector<TableCell> row(const Record& r) {
  std::vector<TableCell> cells = {name_cell(r), contender(r), code_cell(settings_text(r))};
  if (r.status == CellStatus::done) {
    const auto values = measured(r);
    cells.insert(cells.end(), values.begin(), values.end());
  } else {
    const bool failed = r.status == CellStatus::failed;
    cells.push_back(failed ? TableCell("failed: " + r.reason, Tone::bad) : reason_cell("not applicable: " + r.reason));
    cells.insert(cells.end(), 5, reason_cell("-"));
  }
  cells.push_back(r.command.empty() ? reason_cell("not recorded") : code_cell(r.command));
  return cells;
}

Blocks write(const ReportData& data) {
  if (data.records.empty()) return {Paragraph{"There are no records.", Tone::muted}};
  std::vector<std::string> machines = machine_lines(data.records);
  Table table{"All records",
              {"scene, material", "technique, backend", "settings", "relative RMSE", "against truth", "FLIP", "prepare",
               "frame: median", "peak memory", "command"},
              {},
              true};
  for (const Record& r : data.records) table.rows.push_back(row(r));
  return {Paragraph{"Times are wall-clock medians of warm runs. Each command makes that cell's image again; the same "
                    "suite run again "
                    "measures them all: `opaline validate SUITE --out DIR`."},
          List{machines}, table};
}

}  // namespace

Section all_records_section() { return {"records", "Machine, records, commands", write}; }

}  // namespace opaline
