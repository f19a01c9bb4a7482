// A run against an earlier one: which cells became slower, less accurate, or do other work, beyond the noise of both.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

struct Change {
  std::string cell;  ///< Record::name()
  std::string what;  ///< "render seconds", "error relative_rmse", "counter done.rays", with " (new)" or " (gone)" if
                     ///< one run lacks it, "status ..."
  double before = 0, now = 0;
  double tolerance = 0;  ///< relative: what noise explains
  bool worse = false;    ///< more time or error, or a cell that is no longer done; else better, or (counters) different
};

struct BaselineComparison {
  std::vector<Change> changes;
  std::size_t compared = 0;  ///< cells done in both
  std::size_t only_before = 0, only_now = 0;
  /// Median of now / before over all times: how much faster or slower the machine was. Times are compared after it is
  /// taken out, so that a change of everything at once shows here alone.
  double machine_factor = 1;
  bool any_worse() const;
};

/// Cells are the same by name. A time has changed when both its median and its minimum differ by more than the larger
/// of 25 % and four standard errors of the measurements' scatter; an error when it differs by more than 1 %; a counter
/// when it differs at all, or when only one of the two runs has it.
BaselineComparison compare_with_baseline(const std::vector<Record>& before, const std::vector<Record>& now);

}  // namespace opaline
