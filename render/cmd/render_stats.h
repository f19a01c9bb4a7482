// What `opaline render --stats` writes.
#pragma once

#include "render/render_scene.h"

#include <nlohmann/json.hpp>

namespace opaline {

/// {"technique", "backend", "device", "seconds": {"load", "gbuffer", "irradiance", "prepare",
/// "render", "total"}, "counters": {"done", "skipped"}, "estimates", "notes", "peak_rss_bytes", "settings"}; settings
/// are those of the technique, and samples, light_samples, seed and exit_lobe. load, total: wall-clock seconds of
/// reading the scene and of everything up to the written images.
nlohmann::ordered_json render_stats(const RenderOptions& options, const RenderResult& result, double load,
                                    double total);

}  // namespace opaline
