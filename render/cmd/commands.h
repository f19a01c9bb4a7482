// `opaline render`. Wrong values throw std::invalid_argument or InputError.
#pragma once

#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `render`: one image of a scene by one technique. The shapes must outlive the app.
void add_render_command(CLI::App& app, const ShapeLibrary& shapes);

}  // namespace opaline
