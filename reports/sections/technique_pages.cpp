// A page per technique: what it is, what it reached, and its paper's own figures beside ours.
#include "render/techniques/technique.h"
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/paper_figures.h"
#include "reports/sections/section.h"
#include "reports/techniques.h"

#include <fmt/format.h>

namespace opaline {
namespace {

std::string edits_text(const InvalidatedBy& by) {
  std::vector<std::string> names;
  if (by.camera) names.push_back("camera");
  if (by.light) names.push_back("light");
  if (by.material) names.push_back("material");
  if (by.geometry) names.push_back("geometry");
  return names.empty() ? "no edit" : fmt::format("edits of {}", fmt::join(names, ", "));
}

void describe(Blocks& blocks, const std::string& name) {
  const Technique* t = registered_technique(name);
  if (t == nullptr) {
    blocks.push_back(Paragraph{"An external technique: it is known by its records alone."});
    return;
  }
  blocks.push_back(Paragraph{t->summary + ". " + t->citation});
  blocks.push_back(
      Paragraph{fmt::format("Backends: {}. Prepared again after {}. Limits: {}.", fmt::join(t->backends, ", "),
                            edits_text(t->invalidated_by), t->limits.empty() ? "none stated" : t->limits)});
}

std::vector<TableCell> row(const SceneGroup& group, const std::vector<const Record*>& cells) {
  const Record* best = most_accurate(cells);
  const std::string nothing = cells.front()->reason.empty() ? "nothing measured" : cells.front()->reason;
  const Record* cheap = cheapest_within(cells, 0.05);
  const auto cell = [](const Record* r, const char* none) {
    if (r == nullptr) return reason_cell(none);
    TableCell c(fmt::format("{} in {} ({}, {})", relative_text(*error_of(*r)), seconds_text(r->seconds.render.median),
                            r->backend, settings_text(*r)));
    c.link = record_anchor(*r);
    return c;
  };
  const auto truth = [&]() -> TableCell {
    const Record* judged = best != nullptr ? best : cells.front();
    const auto error = truth_error_of(*judged);
    return error ? number_cell(relative_text(*error)) : reason_cell("the suite does not ask for truth here");
  };
  return {group.title(), cell(best, nothing.c_str()), cell(cheap, "nothing within 5 %"), truth()};
}

Table reached(const ReportData& data, const std::string& name) {
  Table table{name + ": what it reached",
              {"scene, material", "most accurate", "cheapest within 5 %", "error against transport"},
              {},
              false};
  for (const SceneGroup& group : scene_groups(data.records)) {
    std::vector<const Record*> cells;
    for (const Record* r : group.records)
      if (r->technique == name) cells.push_back(r);
    if (!cells.empty()) table.rows.push_back(row(group, cells));
  }
  table.folded = table.rows.size() > 12;
  return table;
}

Blocks write(const ReportData& data) {
  Blocks blocks;
  for (const std::string& name : shown_techniques(data.records)) {
    blocks.push_back(Heading{name, "technique-" + name});
    describe(blocks, name);
    Table table = reached(data, name);
    table.rows.empty() ? blocks.push_back(Paragraph{"No record: it was not part of this run.", Tone::muted})
                       : blocks.push_back(table);
    if (auto figures = paper_table(name, data.records)) blocks.push_back(*figures);
  }
  return blocks;
}

}  // namespace

Section technique_pages_section() { return {"techniques", "Technique by technique", write}; }

}  // namespace opaline
