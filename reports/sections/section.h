// The contract of a section, and the registry of all of them.
//
// A section is one <name>.cpp in this folder and one line in CMakeLists.txt; the order of the lines is the report's.
// It writes what it knows from the data, and where there is nothing to show it says why: no section is ever empty.
#pragma once

#include "reports/document.h"
#include "reports/report_data.h"

namespace opaline {

struct Section {
  std::string id, title;  ///< id: anchor in the page
  Blocks (*write)(const ReportData& data);
};

/// All registered sections in the order of CMakeLists.txt.
const std::vector<Section>& sections();

/// Every section written. Throws std::logic_error for one that wrote nothing.
std::vector<Chapter> write_sections(const ReportData& data);

}  // namespace opaline
