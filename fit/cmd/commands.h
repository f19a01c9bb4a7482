// `opaline fit`. Wrong input throws InputError or std::invalid_argument.
#pragma once

#include "render/scene/shapes.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// Adds `fit`: scattering coefficients from pictures. The shapes must outlive the app.
void add_fit_command(CLI::App& app, const ShapeLibrary& shapes);

}  // namespace opaline
