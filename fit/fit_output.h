// What a fit leaves behind: fit.json and pictures.
#pragma once

#include "fit/fit_job.h"

#include <nlohmann/json.hpp>

namespace opaline {

/// The document of fit.json (README, "A first fit"). Values nobody knows are null.
nlohmann::json fit_json(const FitReport& report);

/// Writes fit.json, report.html (fit/report), material.json (ready to paste into a scene; left out unless `usable`),
/// and per target refit, difference and the fitted target as EXR and PNG. Makes the folder; each file is complete or
/// absent. Returns the paths.
std::vector<std::string> write_fit(const FitReport& report, const std::string& directory, bool usable = true);

/// Signed difference as colours: blue too dark, white equal, red too bright; `scale` saturates.
Image signed_colours(const Image& difference, double scale);

}  // namespace opaline
