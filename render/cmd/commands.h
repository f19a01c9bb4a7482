// `opaline render`. Wrong values throw std::invalid_argument or InputError.
#pragma once

#include "render/cmd/chooser.h"
#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `render`: one image of a scene by one technique. The shapes must outlive the app. With a chooser, the technique
/// may be left to it (--max-error, --budget).
void add_render_command(CLI::App& app, const ShapeLibrary& shapes, const TechniqueChooser& chooser = {});

/// Adds `depth-texture`: how deep layers lie below a surface, from their meshes.
void add_depth_texture_command(CLI::App& app);

}  // namespace opaline
