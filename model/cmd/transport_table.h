// The parts of `opaline transport` that concern the profile transport_table.
#pragma once

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `table` and `errors`.
void add_transport_table_commands(CLI::App& transport);

}  // namespace opaline
