// `opaline render` and `opaline compare`. Wrong values throw std::invalid_argument or InputError, a
// comparison beyond its limits throws CommandFailed (exit_status.h).
#pragma once

#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `render`: one image of a scene by one technique. The shapes must outlive the app.
void add_render_command(CLI::App& app, const ShapeLibrary& shapes);

/// Adds `depth-texture`: how deep layers lie below a surface, from their meshes.
void add_depth_texture_command(CLI::App& app);

/// Adds `compare`: error metrics of an image against a reference.
void add_compare_command(CLI::App& app);

}  // namespace opaline
