// `opaline dataset`. Wrong values throw std::invalid_argument or InputError.
#pragma once

#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `dataset list` and `dataset make`. The shapes must outlive the app.
void add_dataset_command(CLI::App& app, const ShapeLibrary& shapes);

}  // namespace opaline
