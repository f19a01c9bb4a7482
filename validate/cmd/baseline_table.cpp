#include "validate/cmd/baseline_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {

std::string baseline_table(const BaselineComparison& c) {
  std::string text = fmt::format(
      "\nagainst the baseline: {} cells compared, {} only in the baseline, {} new; frames took {:.2f} times as long "
      "(taken out below)\n",
      c.compared, c.only_before, c.only_now, c.machine_factor);
  std::vector<Change> changes = c.changes;
  std::stable_sort(changes.begin(), changes.end(), [](const Change& a, const Change& b) { return a.worse > b.worse; });
  for (const Change& change : changes)
    text += fmt::format("{:<6} {:<28} {:>12.4g} -> {:<12.4g} {}\n", change.worse ? "WORSE" : "", change.what,
                        change.before, change.now, change.cell);
  return text + (changes.empty() ? "nothing changed beyond noise\n" : "");
}

}  // namespace opaline
