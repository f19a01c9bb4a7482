// The fitted material as files for other programs.
#pragma once

#include "model/materials/exchange.h"
#include "render/scene/scene.h"

#include <string>
#include <vector>

namespace opaline {

ExchangeMaterial exchange_material(const Material& material);

/// material_FORMAT.EXTENSION per format name into the folder, each complete or absent; appends the paths to `written`.
void write_exports(const Material& material, const std::vector<std::string>& formats, const std::string& directory,
                   std::vector<std::string>& written);

}  // namespace opaline
