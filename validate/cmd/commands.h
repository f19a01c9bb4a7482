// `opaline compare`. Wrong values throw std::invalid_argument or InputError, a comparison beyond its limits throws
// CommandFailed (exit_status.h).
#pragma once

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `compare`: error metrics of an image against a reference.
void add_compare_command(CLI::App& app);

}  // namespace opaline
