// Makes a synthetic dataset of a recipe: the picture a camera would have taken of a known material,
// the scene a fit starts from, and the certified answer.
#pragma once

#include "datasets_synthetic/recipe.h"
#include "render/image.h"
#include "render/render_scene.h"
#include "render/scene/shapes.h"

#include <array>
#include <string>

namespace opaline {

/// Everything a dataset consists of, in memory.
struct Dataset {
  nlohmann::json scene;                       ///< the true material replaced by neutral_start()
  nlohmann::json truth_scene;                 ///< as rendered; like `scene` with paths made absolute
  nlohmann::json truth;                       ///< {"format": "opaline-truth", ...}: see recipes/recipe.md
  Image clean, target;                        ///< R, G, B, A: as rendered, and with noise
  std::map<std::string, std::string> header;  ///< of both images
};

/// The material a fit starts from: sigma_a 0.05 / mm, sigma_s' 1 / mm, eta 1.35, whatever the truth.
nlohmann::json neutral_start();

/// Adds Gaussian noise, independent per pixel and channel, to R, G and B where A is 1; other pixels
/// and A stay. The standard deviation of a channel is `relative` times the channel's RMS over those
/// pixels; returns the three. Numbered per pixel and channel by `seed`: no thread, order or other
/// pixel matters. Values may fall below 0.
std::array<double, 3> add_noise(Image& image, double relative, std::uint64_t seed);

/// Renders the recipe's scene and derives the rest. Throws InputError for a scene or technique that
/// is wrong, a material that the scene lacks or no object has, or a camera that sees no such object.
Dataset compute_dataset(const Recipe& recipe, const ShapeLibrary& shapes, const StageObserver& observer = {});

/// Computes the dataset and writes scene.json, truth_scene.json, truth.json, target.exr, target.png
/// and clean.exr into `folder`, which is made if it is missing (with the folders above it). Every
/// file is whole or absent, and nothing is written before all of them are computed. Throws
/// InputError as compute_dataset, or when the folder cannot be written.
void make_dataset(const Recipe& recipe, const std::string& folder, const ShapeLibrary& shapes,
                  const StageObserver& observer = {});

}  // namespace opaline
