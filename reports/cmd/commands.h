// `opaline report`. Bad input throws InputError.
#pragma once

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `report`: a folder of results as one HTML file, Markdown and CSV.
void add_report_command(CLI::App& app);

}  // namespace opaline
