#include "validate/cmd/judge.h"

#include "model/cmd/exit_status.h"
#include "render/scene/json_object.h"
#include "validate/cmd/baseline_table.h"
#include "validate/cmd/gate_table.h"
#include "validate/junit.h"

#include <fmt/format.h>

#include <filesystem>

namespace opaline {
namespace {

/// A records.jsonl, or the folder that holds one.
std::vector<Record> baseline_records(const std::string& path) {
  std::error_code ignored;
  const bool folder = std::filesystem::is_directory(path, ignored);
  return read_records(folder ? path + "/records.jsonl" : path).records;
}

}  // namespace

Judge::Judge(const JudgeOptions& options) : options_(options) {
  if (!options.gates.empty()) gates_ = find_gates(options.gates).gates;
  if (!options.baseline.empty()) before_ = baseline_records(options.baseline);
}

void Judge::judge(const std::string& suite, const std::string& folder, const std::vector<Record>& records) const {
  const std::vector<GateResult> results = check_gates(gates_, records);
  if (!gates_.empty()) {
    fmt::print("{}", gate_table(results));
    write_text_atomically(folder + "/gates.json", to_json(results).dump(2) + "\n");
  }
  if (!options_.junit.empty()) write_text_atomically(options_.junit, junit_xml(suite, results, records));
  const BaselineComparison comparison = compare_with_baseline(before_, records);
  if (!options_.baseline.empty()) fmt::print("{}", baseline_table(comparison));
  if (failed_gates(results) > 0) throw CommandFailed(fmt::format("{} gates fell short", failed_gates(results)));
  if (!options_.baseline.empty() && comparison.any_worse()) throw CommandFailed("the run is worse than its baseline");
}

}  // namespace opaline
