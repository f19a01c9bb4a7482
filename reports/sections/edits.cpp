// What the first frame after an edit of the scene costs.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

namespace opaline {
namespace {

constexpr const char* edits[] = {"camera", "light", "material", "geometry"};

TableCell edit_cell(const Record& r, const std::string& edit) {
  const auto it = r.seconds.edits.find(edit);
  if (it == r.seconds.edits.end()) return reason_cell("the suite does not time it");
  const EditCost& cost = it->second;
  const std::string prepare = cost.prepare > 0 ? ", prepare " + seconds_text(cost.prepare) : "";
  return number_cell(fmt::format("{} (shared {}{})", seconds_text(cost.total), seconds_text(cost.shared), prepare));
}

Blocks write(const ReportData& data) {
  Table table{"Time of the first frame after an edit",
              {"scene, material", "technique, backend", "settings", "camera", "light", "material", "geometry"},
              {},
              false};
  for (const Record& r : data.records) {
    if (r.status != CellStatus::done || r.seconds.edits.empty()) continue;
    std::vector<TableCell> row = {r.material.empty() ? r.scene : r.scene + ", " + r.material, contender(r),
                                  code_cell(settings_text(r))};
    row[1].link = record_anchor(r);
    for (const char* edit : edits) row.push_back(edit_cell(r, edit));
    table.rows.push_back(row);
  }
  if (table.rows.empty()) return {Paragraph{"No record times edits: the suite asks for none.", Tone::muted}};
  table.folded = table.rows.size() > 20;
  return {
      Paragraph{
          "Total, of which: what all techniques share (rays, view, cells and "
          "irradiance as far as the edit asks), and what the technique prepares again where the edit asks for that."},
      table};
}

}  // namespace

Section edits_section() { return {"edits", "After an edit", write}; }

}  // namespace opaline
