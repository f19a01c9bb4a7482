#include "datasets_synthetic/layered/layered_datasets.h"

#include "render/input_error.h"
#include "render/scene/json_object.h"

#include <cmath>
#include <filesystem>
#include <functional>

namespace opaline {
namespace {

/// An image of depths by a formula of u, v (0 .. 1, v upwards).
Image by_formula(int width, int height, std::vector<std::string> channels,
                 const std::function<std::vector<double>(double, double)>& depths) {
  Image image(width, height, std::move(channels));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::vector<double> d = depths((x + 0.5) / width, 1 - (y + 0.5) / height);
      for (std::size_t c = 0; c < d.size(); ++c) image.at(x, y, static_cast<int>(c)) = static_cast<float>(d[c]);
    }
  return image;
}

/// Thickness of a vessel of that radius at a distance from its middle.
double vessel(double distance, double radius) {
  const double inside = 1 - distance * distance / (radius * radius);
  return inside > 0 ? 2 * radius * std::sqrt(inside) : 0;
}

/// u runs from tail to nose over 60 mm, v from belly to back over about 25 mm.
Image fish_depths() {
  return by_formula(512, 256, {"R", "G", "B"}, [](double u, double v) {
    const double x = 60 * u, y = 25 * (v - 0.47);
    const double scales = 0.02 * std::sin(4 * x) * std::sin(4 * y);
    const double dermis = 0.35 + scales;
    double blood = x > 9 && x < 50 ? vessel(y - 0.4 * std::sin(0.15 * x), 0.22) : 0;
    // Ribs lean backwards from the spine, three millimetres apart.
    if (x > 18 && x < 46 && std::abs(y) < 4) {
      const double along = x + 0.5 * std::abs(y);
      blood = std::max(blood, vessel(along - 3 * std::round(along / 3), 0.16));
    }
    const double belly = std::exp(-std::pow((x - 38) / 8, 2) - std::pow((y + 1) / 3, 2));
    return std::vector<double>{dermis, dermis + blood, dermis + 1.6 + 1.6 * belly};
  });
}

/// Distance from the nearest of a few wandering lines up the head, as a share of the way round.
double nearest_vein(double u, double v) {
  double nearest = 1;
  for (int i = 0; i < 9; ++i) {
    const double at = i / 9.0 + 0.03 * std::sin(17 * v + 2 * i) + 0.012 * std::sin(43 * v + 5 * i);
    nearest = std::min(nearest, std::abs(std::remainder(u - at, 1.0)));
    // Each has a branch that leaves it half-way up.
    if (v > 0.45) {
      const double branch = at + (i % 2 ? 0.12 : -0.12) * (v - 0.45) / 0.55;
      nearest = std::min(nearest, std::abs(std::remainder(u - branch, 1.0)));
    }
  }
  return nearest;
}

Image head_depths() {
  return by_formula(1024, 512, {"R", "G", "B", "A"}, [](double u, double v) {
    const double around = 130;  // mm, about
    const double epidermis = 0.12, dermis = 0.6 + 0.1 * std::sin(23 * u) * std::sin(19 * v);
    const double blood = 1.4 * vessel(around * nearest_vein(u, v), 0.35);
    return std::vector<double>{epidermis, dermis, dermis + blood, dermis + blood + 2.5};
  });
}

nlohmann::json fish_scene() {
  return nlohmann::json::parse(R"({
    "format": "opaline-scene", "version": 1, "mm_per_unit": 1.0,
    "film": {"width": 800, "height": 600},
    "camera": {"type": "perspective", "position": [15, 10, 140], "look_at": [0, 0.5, 0], "up": [0, 1, 0], "fov_y_deg": 22},
    "lights": [
      {"type": "point", "position": [40, 50, 90], "intensity": [40000, 40000, 40000]},
      {"type": "point", "position": [0, -90, 30], "intensity": [16000, 16000, 20000]},
      {"type": "point", "position": [-30, 40, -90], "intensity": [40000, 36000, 30000]}
    ],
    "materials": {"fish": {"eta": 1.35, "layers": {
      "depth_textures": [{"image": "depths.exr", "wrap": "clamp"}],
      "media": [
        {"sigma_s_per_mm": [2, 1, 1], "sigma_t_per_mm": [2.6, 1.6, 1.6], "g": 0.25, "phase": "schlick"},
        {"sigma_s_per_mm": [6, 3, 2], "sigma_t_per_mm": [6.6, 3.6, 2.6], "g": 0.4, "phase": "schlick"},
        {"sigma_s_per_mm": [1, 1, 2], "sigma_t_per_mm": [1.5, 1.5, 2.5], "g": 0.8, "phase": "schlick"}]}}},
    "objects": [{"shape": "fish", "length": 60, "triangles": 4000, "material": "fish", "texture_coordinates": "planar"}]
  })");
}

nlohmann::json head_scene() {
  return nlohmann::json::parse(R"({
    "format": "opaline-scene", "version": 1, "mm_per_unit": 1.0,
    "film": {"width": 800, "height": 600},
    "camera": {"type": "perspective", "position": [-70, 30, 220], "look_at": [0, 18, 0], "up": [0, 1, 0], "fov_y_deg": 24},
    "lights": [
      {"type": "directional", "direction": [0.5, -0.4, -0.8], "irradiance": [5, 5, 5]},
      {"type": "directional", "direction": [-0.9, -0.1, -0.3], "irradiance": [2, 2, 2.5]},
      {"type": "directional", "direction": [0.3, -0.2, 0.9], "irradiance": [4, 3.5, 3]}
    ],
    "materials": {"skin": {"eta": 1.4, "layers": {
      "depth_textures": [{"image": "depths.exr", "wrap": "repeat"}],
      "media": [
        {"sigma_s_per_mm": [1.2, 1.0, 0.8], "sigma_t_per_mm": [1.4, 1.3, 1.2], "g": 0.6, "phase": "henyey_greenstein"},
        {"sigma_s_per_mm": [1.6, 1.3, 1.1], "sigma_t_per_mm": [1.7, 1.6, 1.6], "g": 0.4, "phase": "schlick"},
        {"sigma_s_per_mm": [3.0, 1.5, 2.5], "sigma_t_per_mm": [3.6, 3.9, 3.3], "g": 0.4, "phase": "schlick"},
        {"sigma_s_per_mm": [1.5, 1.0, 0.8], "sigma_t_per_mm": [1.6, 1.5, 1.5], "g": 0.3, "phase": "schlick"}]}}},
    "objects": [{"shape": "bust", "height": 120, "material": "skin", "texture_coordinates": "cylindrical"}]
  })");
}

}  // namespace

const std::vector<LayeredDataset>& layered_datasets() {
  static const std::vector<LayeredDataset> all = {
      {"fish_layers", "a fish of dermis, blood and organs with three point lights, one of them behind", fish_scene,
       fish_depths},
      {"head_veins", "a bust with veins under two layers of skin, lit from three sides", head_scene, head_depths}};
  return all;
}

const LayeredDataset* find_layered_dataset(const std::string& name) {
  for (const LayeredDataset& dataset : layered_datasets())
    if (dataset.name == name) return &dataset;
  return nullptr;
}

void write_layered_dataset(const LayeredDataset& dataset, const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw InputError(folder, "", "the folder cannot be made: " + error.message());
  const auto file = [&](const char* name) { return (std::filesystem::path(folder) / name).string(); };
  write_exr(file("depths.exr"), dataset.depths());
  write_text_atomically(file("scene.json"), dataset.scene().dump(2) + "\n");
}

}  // namespace opaline
