#include "validate/cmd/gate_table.h"

#include <fmt/format.h>

#include <algorithm>

namespace opaline {

std::size_t failed_gates(const std::vector<GateResult>& results) {
  return static_cast<std::size_t>(std::count_if(
      results.begin(), results.end(), [](const GateResult& r) { return r.outcome == GateResult::Outcome::failed; }));
}

std::string gate_table(const std::vector<GateResult>& results) {
  std::string text = "\ngate     value        limit        what\n";
  for (const GateResult& r : results) {
    const bool skipped = r.outcome == GateResult::Outcome::skipped, failed = r.outcome == GateResult::Outcome::failed;
    text += fmt::format("{:<8} {:<12} {:<12} {}\n",
                        failed    ? "FAILED"
                        : skipped ? "skipped"
                                  : "ok",
                        r.where.empty() && r.value == 0 && r.outcome != GateResult::Outcome::passed
                            ? "-"
                            : fmt::format("{:.4g}", r.value),
                        fmt::format("{} {:.4g}", r.upper ? "<=" : ">=", r.limit), r.name);
    if (failed || skipped) text += fmt::format("{:35}{}{}\n", "", r.message, r.where.empty() ? "" : " at " + r.where);
  }
  return text + fmt::format("{} gates, {} failed\n", results.size(), failed_gates(results));
}

}  // namespace opaline
