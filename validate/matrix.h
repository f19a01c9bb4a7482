// Runs a suite: measures every cell that has no record yet, one after the other, each alone.
//
// In DIR: records.jsonl (record.h), images/ (renders, references, bounds, truth), scenes/ (what `opaline render` can be
// given to make an image again), cache/ (shared parts by content; may be deleted).
#pragma once

#include "render/scene/shapes.h"
#include "validate/cells.h"
#include "validate/record.h"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace opaline {

struct RunOptions {
  std::string folder;  ///< its file "measuring" holds the hash of the cell that is being measured
  CellChoice choice;
  bool remeasure = false;  ///< also cells that have a record
  /// Cells by hash that are not tried again, and why: they ended the program before.
  std::map<std::string, std::string> failed;
};

struct RunSummary {
  std::vector<Record> records;  ///< of all chosen cells of the suite, in order
  std::size_t measured = 0;     ///< of these, in this run
  double seconds = 0;
  /// Of `seconds`: all but the work of techniques, references, shared parts, metrics and writing of images.
  double overhead_seconds = 0;
};

/// Called before a cell is measured, with its name and how many are done of how many.
using CellObserver = std::function<void(const std::string& name, std::size_t done, std::size_t of)>;

/// A cell that fails becomes a record with its reason; a scene that cannot be loaded makes all its cells fail. Throws
/// InputError for a choice the suite lacks or a folder that cannot be written.
RunSummary run_suite(const Suite& suite, const RunOptions& options, const ShapeLibrary& shapes,
                     const CellObserver& observer = {});

}  // namespace opaline
