// Work that was not done because the scene doesn't need it, by the counters.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

namespace opaline {
namespace {

struct Tally {
  std::uint64_t done = 0, skipped = 0;
  std::string work;    ///< the counter of what was done of this work; empty if there is none
  double largest = 0;  ///< largest share of one cell
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

/// The counter of the same work done: what is skipped has its name, or that and the reason ("shadow_rays" and
/// "shadow_rays_facing_away"). Of several the longest name; empty if none fits.
std::string work_of(const std::string& skipped, const std::map<std::string, std::uint64_t>& done) {
  for (std::size_t end = skipped.size(); end != std::string::npos && end > 0; end = skipped.rfind('_', end - 1))
    if (done.count(skipped.substr(0, end)) != 0) return skipped.substr(0, end);
  return {};
}

/// By technique and backend, then by counter: every counter that is skipped somewhere.
std::map<std::string, std::map<std::string, Tally>> tallies(const std::vector<Record>& records) {
  std::map<std::string, std::map<std::string, Tally>> all;
  for (const Record& r : records)
    for (const auto& [name, count] : r.skipped) {
      const std::string work = work_of(name, r.done);
      Tally& tally = all[contender(r)][name];
      if (!work.empty()) tally.work = work;
      add(tally, r, work.empty() ? 0 : r.done.at(work), count);
    }
  return all;
}

std::vector<TableCell> row(const std::string& who, const std::string& counter, const Tally& t) {
  const bool has_done = !t.work.empty();
  const std::string of = t.work == counter ? "" : " " + words(t.work);
  return {who,
          words(counter),
          has_done ? number_cell(count_text(t.done) + of) : reason_cell("-"),
          number_cell(count_text(t.skipped)),
          has_done ? number_cell(relative_text(share(t.done, t.skipped))) : reason_cell("-"),
          has_done && !t.largest_in.empty() ? TableCell(fmt::format("{} in {}", relative_text(t.largest), t.largest_in))
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
          "and the same on every machine. What was saved is a share of the same work, done and skipped: the counter "
          "done whose name that of the skipped one begins with, which stands beside its count where they differ. A "
          "\"-\" means that there is none."},
      table};
}

}  // namespace

Section skipped_section() { return {"skipped", "Work skipped", write}; }

}  // namespace opaline
