// Scene x technique x backend: the most accurate result of each, or the reason why there is none.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/sections/section.h"
#include "reports/techniques.h"

#include <fmt/format.h>

#include <set>

namespace opaline {
namespace {

std::vector<const Record*> cells_of(const SceneGroup& group, const std::string& technique, const std::string& backend) {
  std::vector<const Record*> cells;
  for (const Record* r : group.records)
    if (r->technique == technique && r->backend == backend) cells.push_back(r);
  return cells;
}

/// A measured cell that the reference does not apply to: its error against truth where there is one.
TableCell without_reference(const Record& r) {
  const std::string why = r.reason.empty() ? "there is no reference it could be compared with" : r.reason;
  const auto truth = truth_error_of(r);
  TableCell cell = truth ? TableCell(fmt::format("{} against truth in {} ({})", relative_text(*truth),
                                                 seconds_text(r.seconds.render.median), why))
                         : reason_cell(why);
  cell.link = record_anchor(r);
  return cell;
}

TableCell reason(const std::vector<const Record*>& cells, const std::string& technique, const std::string& backend) {
  for (const Record* r : cells)
    if (r->status == CellStatus::failed) return TableCell("failed: " + r->reason, Tone::bad);
  for (const Record* r : cells)
    if (r->status == CellStatus::not_applicable) return reason_cell("not applicable: " + r->reason);
  if (!cells.empty()) return without_reference(*cells.front());
  return reason_cell(absence_reason(technique, backend));
}

TableCell matrix_cell(const SceneGroup& group, const std::string& technique, const std::string& backend) {
  const auto cells = cells_of(group, technique, backend);
  const Record* best = most_accurate(cells);
  if (best == nullptr) return reason(cells, technique, backend);
  TableCell cell(fmt::format("{} in {} ({})", relative_text(*error_of(*best)),
                             seconds_text(best->seconds.render.median), settings_text(*best)));
  cell.link = record_anchor(*best);
  return cell;
}

Blocks write(const ReportData& data) {
  if (data.records.empty()) return {Paragraph{"There are no records.", Tone::muted}};
  const auto groups = scene_groups(data.records);
  const auto techniques = shown_techniques(data.records);
  const auto backends = shown_backends(data.records);
  Table table{"Relative RMS error and time of a frame at the most accurate settings",
              {"scene, material", "technique"},
              {},
              groups.size() * techniques.size() > 30};
  table.header.insert(table.header.end(), backends.begin(), backends.end());
  for (const SceneGroup& group : groups)
    for (const std::string& technique : techniques) {
      std::vector<TableCell> row = {group.title(), technique};
      for (const std::string& backend : backends) row.push_back(matrix_cell(group, technique, backend));
      table.rows.push_back(row);
    }
  return {Paragraph{"Every technique on every scene and backend. A cell without numbers says why."}, table};
}

}  // namespace

Section matrix_section() { return {"matrix", "Every technique on every scene", write}; }

}  // namespace opaline
