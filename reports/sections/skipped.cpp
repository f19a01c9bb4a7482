// Work that was not done because the scene doesn't need it, by the counters.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

namespace opaline {
namespace {

struct Tally {
  std::uint64_t done = 0, skipped = 0;
  bool has_done = false;  ///< is there a counter of work done with this name?
  double largest = 0;     ///< largest share of one cell
  std::string largest_in;
};

double share(std::uint64_t done, std::uint64_t skipped) {
  return done + skipped == 0 ? 0 : static_cast<double>(skipped) / static_cast<double>(done + skipped);
}

void add(Tally& tally, const Record& r, std::uint64_t done, std::uint64_t skipped) {
  tally.done += done;
  tally.skipped += skipped;
  if (share(done, skipped) <= tally.largest) return;
  tally.largest = share(done, skipped);
  tally.largest_in = r.scene;
}

/// By technique and backend, then by counter: every counter that is skipped somewhere.
std::map<std::string, std::map<std::string, Tally>> tallies(const std::vector<Record>& records) {
  std::map<std::string, std::map<std::string, Tally>> all;
  for (const Record& r : records)
    for (const auto& [name, count] : r.skipped) {
      const auto done = r.done.find(name);
      Tally& tally = all[contender(r)][name];
      tally.has_done |= done != r.done.end();
      add(tally, r, done == r.done.end() ? 0 : done->second, count);
    }
  return all;
}

std::vector<TableCell> row(const std::string& who, const std::string& counter, const Tally& t) {
  return {who,
          words(counter),
          t.has_done ? number_cell(count_text(t.done)) : reason_cell("-"),
          number_cell(count_text(t.skipped)),
          t.has_done ? number_cell(relative_text(share(t.done, t.skipped))) : reason_cell("-"),
          t.has_done && !t.largest_in.empty()
              ? TableCell(fmt::format("{} in {}", relative_text(t.largest), t.largest_in))
              : reason_cell("-")};
}

Blocks write(const ReportData& data) {
  Table table{"Counted over all cells",
              {"technique, backend", "work", "done", "skipped", "saved", "most in one scene"},
              {},
              false};
  for (const auto& [who, counters] : tallies(data.records))
    for (const auto& [counter, tally] : counters)
      if (tally.skipped > 0) table.rows.push_back(row(who, counter, tally));
  if (table.rows.empty()) return {Paragraph{"No record counts skipped work.", Tone::muted}};
  return {
      Paragraph{
          "Work a scene doesn't need is not done; the counters of each cell say how much that was. Counts are exact "
          "and the same on every machine. A \"-\" means that nothing done is counted by the name of what was skipped."},
      table};
}

}  // namespace

Section skipped_section() { return {"skipped", "Work skipped", write}; }

}  // namespace opaline
