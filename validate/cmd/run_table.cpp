#include "validate/cmd/run_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

std::string settings_text(const Record& r) {
  std::string text;
  for (const auto& [key, value] : r.settings) text += fmt::format("{}{}={}", text.empty() ? "" : " ", key, value);
  return text;
}

std::string value_or_dash(const std::map<std::string, double>& values, const std::string& name) {
  const auto it = values.find(name);
  return it == values.end() ? "-" : fmt::format("{:.3g}", it->second);
}

std::string row(const Record& r) {
  const std::string what = fmt::format("  {} {} {}", r.technique, r.backend, settings_text(r));
  if (r.status != CellStatus::done) return fmt::format("{:<58} {}: {}\n", what, status_name(r.status), r.reason);
  const std::map<std::string, double> none;
  return fmt::format("{:<58}{:>10.2f}{:>10.2f}{:>11}{:>11}{:>11}\n", what, 1e3 * r.seconds.prepare.median,
                     1e3 * r.seconds.render.median, value_or_dash(r.error, "relative_rmse"),
                     value_or_dash(r.error, "flip"),
                     value_or_dash(r.truth_error ? *r.truth_error : none, "relative_rmse"));
}

std::size_t count(const RunSummary& summary, CellStatus status) {
  return static_cast<std::size_t>(std::count_if(summary.records.begin(), summary.records.end(),
                                                [&](const Record& r) { return r.status == status; }));
}

}  // namespace

std::string run_table(const RunSummary& summary) {
  std::string text, group;
  for (const Record& r : summary.records) {
    if (const std::string g = r.scene + ", " + r.material; g != group) {
      group = g;
      text += fmt::format("{}{:<58}{:>10}{:>10}{:>11}{:>11}{:>11}\n", text.empty() ? "" : "\n", group, "prepare",
                          "render", "rel.", "FLIP", "to truth");
      text += fmt::format("{:<58}{:>10}{:>10}{:>11}{:>11}{:>11}\n", "", "ms", "ms", "RMSE", "", "rel. RMSE");
    }
    text += row(r);
  }
  return text;
}

std::string run_totals(const Suite& suite, const RunOptions& options, const RunSummary& summary) {
  return fmt::format(
      "\nsuite {}: {} cells done, {} not applicable, {} failed; {} measured now in {:.1f} s, of which the harness "
      "took {:.2f} %\nrecords: {}/records.jsonl\n",
      suite.name, count(summary, CellStatus::done), count(summary, CellStatus::not_applicable),
      count(summary, CellStatus::failed), summary.measured, summary.seconds,
      summary.seconds > 0 ? 100 * summary.overhead_seconds / summary.seconds : 0.0, options.folder);
}

std::string repeat_table(const RunSummary& first, const RunSummary& second) {
  std::vector<std::pair<double, std::string>> differences;
  for (std::size_t i = 0; i < std::min(first.records.size(), second.records.size()); ++i) {
    const Record &a = first.records[i], &b = second.records[i];
    if (a.status != CellStatus::done || b.status != CellStatus::done || a.name() != b.name()) continue;
    differences.emplace_back(std::abs(b.seconds.render.median / a.seconds.render.median - 1), a.name());
  }
  if (differences.empty()) return "nothing was measured twice\n";
  std::sort(differences.begin(), differences.end());
  const auto& [typical, ignored] = differences[differences.size() / 2];
  return fmt::format(
      "\nmeasured twice: the median frame time of {} cells differs by {:.1f} % (median), {:.1f} % at most: {}\n",
      differences.size(), 100 * typical, 100 * differences.back().first, differences.back().second);
}

}  // namespace opaline
