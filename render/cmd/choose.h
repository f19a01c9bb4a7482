// The options by which `opaline render` leaves the technique to a chooser.
#pragma once

#include "render/cmd/chooser.h"
#include "render/render_scene.h"

#include <CLI/CLI.hpp>

namespace opaline {

/// --max-error, --budget and --records.
void add_choice_options(CLI::App& command, ChoiceRequest& request);

bool asks_for_choice(const ChoiceRequest& request);

/// Throws std::invalid_argument when the request contradicts itself or the options.
void check_choice_request(const ChoiceRequest& request, const RenderOptions& options);

/// Sets technique, backend, settings and samples to the first choice that can render the scene, and says why on stderr.
void choose_technique(const Scene& scene, ChoiceRequest request, const TechniqueChooser& chooser,
                      RenderOptions& options);

}  // namespace opaline
