// The figures papers print, as data (papers/NAME.json, one file per technique, built in), beside what the records say.
//
//   {"technique": NAME, "paper": citation,
//    "figures": [{"what", "where": place in the paper, "paper": what it prints,
//                 "ours": {"quantity": ..., "of": SELECT, "over": SELECT}, "note"}]}
//
// quantity  "seconds.render", "seconds.prepare", "frames_per_second", "error.METRIC", "truth_error.METRIC",
//           "counters.done.NAME" or "counters.skipped.NAME"
// SELECT    {"technique", "backend", "scene", "material", "settings": {key: value}}: records that agree in what is
//           named; the technique is the file's own unless named. A setting the sweep left alone has its default.
// over      the figure is a ratio: to the record of the same scene, material and (unless named) backend that `over`
//           selects, all other settings equal where the technique is the same.
#pragma once

#include "reports/document.h"
#include "validate/record.h"

#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// The values of one "ours" over all records that fit, sorted. Throws std::invalid_argument for an unknown quantity.
std::vector<double> figure_values(const nlohmann::json& ours, const std::string& technique,
                                  const std::vector<Record>& records);

/// The technique's figures as a table, or nothing where no file speaks of it.
std::optional<Table> paper_table(const std::string& technique, const std::vector<Record>& records);

/// Technique names of the files that are built in, sorted.
std::vector<std::string> techniques_with_papers();

/// One file's document; throws std::invalid_argument for a name without a file.
const nlohmann::json& paper_document(const std::string& technique);

}  // namespace opaline
