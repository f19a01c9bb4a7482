// `opaline compare` and `opaline validate`. Wrong values throw std::invalid_argument or InputError, a comparison beyond
// its limits throws CommandFailed (exit_status.h).
#pragma once

#include "render/cmd/chooser.h"
#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `compare`: error metrics of an image against a reference.
void add_compare_command(CLI::App& app);

/// Adds `validate`: what every technique costs and how wrong it is. The shapes must outlive the app.
void add_validate_command(CLI::App& app, const ShapeLibrary& shapes);

/// What `opaline render --max-error E` and `--budget MS` take, out of a folder of records. Throws InputError when the
/// folder has none, or none that keeps the limit, naming the nearest.
std::vector<TechniqueChoice> choose_from_records(const ChoiceRequest& request);

}  // namespace opaline
