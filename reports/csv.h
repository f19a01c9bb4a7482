// Records as one flat table, for spreadsheets and scripts (RFC 4180, UTF-8, "." as decimal point).
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

/// A field as CSV: in quotes where it holds a comma, a quote or a line end. A text that a spreadsheet would take for a
/// formula (it begins with = + - @) gets an apostrophe in front; numbers do not go through here.
std::string csv_escaped(const std::string& text);

/// A header line and one line per record. Columns: what identifies the cell, status and reason, times [s], peak memory
/// [bytes], each error ("error.NAME", "truth_error.NAME"), each counter ("done.NAME", "skipped.NAME"), machine,
/// command. A value that a record lacks, or that isn't finite, is empty.
std::string records_csv(const std::vector<Record>& records);

}  // namespace opaline
