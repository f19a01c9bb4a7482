// Synthetic scenes of layered materials: shapes and depth textures by formula, for techniques of single scattering.
//
//   fish_layers  a fish 60 mm long of dermis, blood in a spine with ribs, and organs: the media of Francois et al.
//   2006,
//                table 1, and their lights, one in front, one beneath and one behind
//   head_veins   a bust 120 mm high of two thin layers of skin over veins and flesh
#pragma once

#include "render/image.h"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace opaline {

struct LayeredDataset {
  std::string name, summary;
  nlohmann::json (*scene)();  ///< names "depths.exr" beside it
  Image (*depths)();          ///< R, G, B (, A): where each layer ends [mm]
};

const std::vector<LayeredDataset>& layered_datasets();

/// The one of that name, or null.
const LayeredDataset* find_layered_dataset(const std::string& name);

/// Writes scene.json and depths.exr into a folder, which is made if it is missing. InputError if it can't be.
void write_layered_dataset(const LayeredDataset& dataset, const std::string& folder);

}  // namespace opaline
