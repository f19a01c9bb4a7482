// CPU against GPU: the same cell on both.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/sections/section.h"
#include "reports/techniques.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {
namespace {

using Pairs = std::vector<std::pair<const Record*, const Record*>>;

/// Name of the cell whatever its backend.
std::string twin_name(Record r) {
  r.backend.clear();
  return r.name();
}

Pairs pairs_of(const std::vector<Record>& records, const std::string& technique) {
  std::map<std::string, const Record*> cpu;
  for (const Record& r : records)
    if (r.technique == technique && r.backend == "cpu" && r.status == CellStatus::done) cpu[twin_name(r)] = &r;
  Pairs pairs;
  for (const Record& r : records)
    if (r.technique == technique && r.backend == "gpu" && r.status == CellStatus::done)
      if (const auto it = cpu.find(twin_name(r)); it != cpu.end()) pairs.emplace_back(it->second, &r);
  return pairs;
}

std::string renderer(const Pairs& pairs) {
  const std::string& name = pairs.front().second->machine.gl_renderer;
  return name.empty() ? "not stated" : name;
}

std::vector<TableCell> row(const std::string& technique, const Pairs& pairs) {
  std::vector<double> ratios;
  for (const auto& [cpu, gpu] : pairs)
    if (gpu->seconds.render.median > 0) ratios.push_back(cpu->seconds.render.median / gpu->seconds.render.median);
  std::sort(ratios.begin(), ratios.end());
  if (ratios.empty())
    return {technique, reason_cell("no frame was timed on both"), reason_cell("-"), reason_cell("-"), reason_cell("-")};
  return {technique, number_cell(std::to_string(ratios.size())), number_cell(number_text(ratios[ratios.size() / 2])),
          number_cell(fmt::format("{} to {}", number_text(ratios.front()), number_text(ratios.back()))),
          renderer(pairs)};
}

/// Why a technique can't be compared.
std::string lone_reason(const std::vector<Record>& records, const std::string& technique) {
  for (const Record& r : records)
    if (r.technique == technique && r.backend == "gpu" && r.status != CellStatus::done) return r.reason;
  return absence_reason(technique, "gpu");
}

void add_pairs(Table& table, const Pairs& pairs) {
  for (const auto& [cpu, gpu] : pairs) {
    const auto error = [](const Record* r) {
      return error_of(*r) ? number_cell(relative_text(*error_of(*r))) : reason_cell("no reference");
    };
    const double ratio = gpu->seconds.render.median > 0 ? cpu->seconds.render.median / gpu->seconds.render.median : 0;
    table.rows.push_back({cpu->scene + ", " + cpu->material, cpu->technique, code_cell(settings_text(*cpu)),
                          number_cell(seconds_text(cpu->seconds.render.median)),
                          number_cell(seconds_text(gpu->seconds.render.median)), number_cell(number_text(ratio)),
                          error(cpu), error(gpu)});
  }
}

Blocks write(const ReportData& data) {
  if (data.records.empty()) return {Paragraph{"There are no records.", Tone::muted}};
  Table overview{"Time of a frame, CPU / GPU (above 1: the GPU is faster)",
                 {"technique", "cells on both", "median", "range", "GL renderer"},
                 {},
                 false};
  Table cells{
      "Every cell on both",
      {"scene, material", "technique", "settings", "CPU frame", "GPU frame", "CPU / GPU", "CPU error", "GPU error"},
      {},
      true};
  for (const std::string& technique : shown_techniques(data.records)) {
    const Pairs pairs = pairs_of(data.records, technique);
    if (pairs.empty())
      overview.rows.push_back({technique, number_cell("0"), reason_cell(lone_reason(data.records, technique)),
                               reason_cell("-"), reason_cell("-")});
    else
      overview.rows.push_back(row(technique, pairs));
    add_pairs(cells, pairs);
  }
  Blocks blocks = {overview};
  if (!cells.rows.empty()) blocks.push_back(cells);
  return blocks;
}

}  // namespace

Section processors_section() { return {"cpu-gpu", "CPU against GPU", write}; }

}  // namespace opaline
