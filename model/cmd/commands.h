// `opaline profile`, `opaline material`, `opaline stress` and `opaline transport`. Wrong values throw
// std::invalid_argument, whose message names the option and the valid choices; the main program turns it into exit
// code 2.
#pragma once

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `profile`: R_d(r) of one model and material, or of several to compare, on stdout as CSV or JSON; and
/// `profile list`: what there is, what it needs and where it holds.
void add_profile_command(CLI::App& app);

/// Adds `material list`, `material show NAME`, `material export` and `material import`.
void add_material_command(CLI::App& app);
/// The last two of them.
void add_material_exchange(CLI::App& material);

/// Adds `stress`: rounding errors and invalid values of every formula; throws CommandFailed (exit_status.h) past a
/// limit.
void add_stress_command(CLI::App& app);

/// Adds `transport`: Monte-Carlo walks, the maker of the profile transport_table, and models' errors against it.
void add_transport_command(CLI::App& app);

}  // namespace opaline
