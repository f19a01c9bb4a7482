// The report as a whole: one HTML file that holds all it needs, the same as Markdown.
#pragma once

#include "reports/document.h"
#include "reports/report_data.h"

#include <string>
#include <vector>

namespace opaline {

/// One HTML document without any reference to another file or host. title: of the page.
std::string report_html(const std::vector<Chapter>& chapters, const std::string& title);

std::string report_markdown(const std::vector<Chapter>& chapters, const std::string& title);

/// "Opaline report: quick" by the suites of the records.
std::string report_title(const ReportData& data);

/// Was the plotting library there when this program was built? Without it pages say so in place of plots.
bool has_plotting_library();

}  // namespace opaline
