// Everything a report shows, read from one folder: what `opaline validate`, `opaline stress` and `opaline fit` left.
//
//   records.jsonl        the records of `opaline validate` (validate/record.h)
//   gates.json           the verdict of its gates
//   stress.json          `opaline stress --json`
//   fits/NAME/fit.json   `opaline fit --out fits/NAME`, its images, and truth.json where the truth is known
//   images/              what the records name
//
// Each may be missing; the report says so in its place.
#pragma once

#include "validate/record.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

struct FitResult {
  std::string name;                           ///< its folder
  nlohmann::json fit;                         ///< fit/fit_output.h
  std::optional<nlohmann::json> truth;        ///< "parameters" of truth.json
  std::map<std::string, std::string> images;  ///< "target", "refit", "difference": paths of those that are there
};

struct ReportData {
  std::string directory;
  std::vector<Record> records;
  std::size_t superseded = 0;
  bool cut = false;  ///< the last line of records.jsonl was unfinished and left out
  std::optional<nlohmann::json> gates, stress;
  std::vector<FitResult> fits;  ///< by name
};

/// Throws InputError for a folder that is missing or holds none of the above, and for a file that is not what its
/// name says.
ReportData read_report_data(const std::string& directory);

}  // namespace opaline
