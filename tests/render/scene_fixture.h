// What the tests of scene input share: a folder of their own, tiny files, a valid document.
#pragma once

#include "render/input_error.h"
#include "render/scene/scene.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>

namespace opaline::test {

/// A fresh folder, removed with its files at the end.
class TempFolder {
 public:
  TempFolder() {
    static std::atomic<int> counter{0};
    path_ = std::filesystem::temp_directory_path() /
            ("opaline-test-" + std::to_string(::getpid()) + "-" + std::to_string(counter++));
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::string write(const std::string& name, const std::string& bytes) const {
    std::ofstream(file(name), std::ios::binary) << bytes;
    return file(name);
  }
  std::size_t file_count() const {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(path_), {}));
  }

 private:
  std::filesystem::path path_;
};

/// The message of the InputError that `run` throws; a test failure when it throws none.
template <typename Run>
std::string message_of(Run run) {
  try {
    run();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no InputError was thrown";
  return "";
}

inline const char* tetrahedron_obj =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// An octahedron of that radius under the name "sphere", and the slab's name.
inline ShapeLibrary test_shapes() {
  const auto octahedron = [](JsonObject& json) {
    const float r = static_cast<float>(json.number("radius", Range::positive()));
    Mesh mesh;
    mesh.positions = {{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}};
    for (const glm::vec3& p : mesh.positions) mesh.normals.push_back(p / r);
    mesh.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
    return mesh;
  };
  const auto none = [](JsonObject&) { return Mesh{}; };
  return {{"slab", {"nothing at all", none}}, {"sphere", {"octahedron: radius", octahedron}}};
}

inline nlohmann::json valid_document() {
  return nlohmann::json::parse(R"({
    "format": "opaline-scene", "version": 1, "mm_per_unit": 1.0,
    "film": {"width": 256, "height": 128},
    "camera": {"type": "perspective", "position": [0,0,60], "look_at": [0,0,0], "up": [0,1,0], "fov_y_deg": 25},
    "lights": [ {"type": "directional", "direction": [0,0,-2], "irradiance": [3.14,3,2]} ],
    "materials": { "m1": {"sigma_a_per_mm": [0.032,0.17,0.48], "sigma_s_prime_per_mm": [0.74,0.88,1.01],
                          "g": 0.25, "eta": 1.3} },
    "objects": [ {"shape": "sphere", "radius": 5, "material": "m1"} ] })");
}

/// The valid document with the value at a JSON pointer replaced (or added).
inline nlohmann::json document_with(const std::string& pointer, const nlohmann::json& value) {
  nlohmann::json document = valid_document();
  document[nlohmann::json::json_pointer(pointer)] = value;
  return document;
}

/// The valid document without what stands at a JSON pointer.
inline nlohmann::json document_without(const std::string& pointer) {
  const nlohmann::json::json_pointer place(pointer);
  nlohmann::json document = valid_document();
  document[place.parent_pointer()].erase(place.back());
  return document;
}

}  // namespace opaline::test
