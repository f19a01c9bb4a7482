// A scene: film, camera, lights, materials, objects. Plain data in mm; see scene.md for the
// file format and scene.schema.json for its JSON Schema.
#pragma once

#include "model/conventions.h"
#include "render/image.h"
#include "render/scene/layered_medium.h"
#include "render/scene/material_map.h"
#include "render/scene/mesh.h"
#include "render/scene/shapes.h"

#include <glm/glm.hpp>

#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace opaline {

using Rgb = glm::dvec3;

struct Film {
  int width = 256, height = 256;  ///< pixels, 1 .. 16384
};

struct Camera {
  enum class Type { perspective, orthographic };
  Type type = Type::perspective;
  glm::dvec3 position{0, 0, 60}, look_at{0}, up{0, 1, 0};  ///< mm
  double fov_y_deg = 25;                                   ///< perspective, 0 < fov < 180
  double height = 20;                                      ///< orthographic, mm
};

/// Light from one direction; a disk of that angular radius when it is > 0.
struct DirectionalLight {
  glm::dvec3 direction{0, 0, -1};  ///< the way the light travels; unit
  Rgb irradiance{1};               ///< on a plane facing the light
  double angular_radius_deg = 0;   ///< 0 .. 90
};
struct PointLight {
  glm::dvec3 position{0};
  Rgb intensity{1};  ///< irradiance = intensity cos / d^2, d in mm
};
/// Latitude-longitude image; +y is up, the image centre is seen looking along -z, u grows to +x.
struct EnvironmentLight {
  std::string path;
  std::shared_ptr<const Image> image;
  Rgb scale{1};  ///< radiance = scale * image
};
/// Slide projector at a point: intensity times the image over its field, or a disk.
struct ProjectorLight {
  glm::dvec3 position{0, 0, 10}, look_at{0}, up{0, 1, 0};
  double fov_y_deg = 10;
  Rgb intensity{1};  ///< as PointLight, per unit image value
  std::string path;
  std::shared_ptr<const Image> image;  ///< null: a disk
  double disk_radius_deg = 0;          ///< half-angle of the disk's cone when there is no image
};
using Light = std::variant<DirectionalLight, PointLight, EnvironmentLight, ProjectorLight>;

/// Coefficients per RGB channel [1/mm]; g is the mean scattering cosine, eta inside/outside.
struct Material {
  std::string name;
  Rgb sigma_a{0}, sigma_s_prime{1};  ///< the mean over the image where there is a map
  double g = 0;                      ///< -1 < g < 1; techniques that use sigma_s take sigma_s' / (1 - g)
  double eta = 1;                    ///< > 0
  /// Null, or the coefficient over the surface; objects of such a material have texture coordinates.
  std::shared_ptr<const MaterialMap> sigma_a_map = nullptr, sigma_s_prime_map = nullptr;

  Medium<double> channel(int c) const { return {sigma_a[c], sigma_s_prime[c], eta}; }
  /// Null, or layers below the surface; the coefficients above are then those of the first layer.
  std::shared_ptr<const LayeredMedium> layers = nullptr;
  bool needs_uvs() const { return textured() || layers; }
  bool textured() const { return sigma_a_map || sigma_s_prime_map; }
  /// The homogeneous material of a place on the surface.
  Material at(const glm::vec2& uv) const;
};

struct Object {
  std::string name;  ///< mesh file or shape name, for messages
  Mesh mesh;         ///< mm, world frame
  int material = 0;  ///< index into Scene::materials
};

struct Scene {
  std::string path;  ///< file it came from, for messages; may be empty
  Film film;
  Camera camera;
  std::vector<Light> lights;
  std::vector<Material> materials;
  std::vector<Object> objects;
  std::size_t dropped_triangles = 0;  ///< zero-area triangles removed on request
};

/// Loads a scene file. Relative paths in it are relative to the file. Throws InputError.
Scene load_scene(const std::string& path, const ShapeLibrary& shapes);

/// As load_scene for a document in memory; `path` names it in messages and anchors relative paths.
Scene parse_scene(const nlohmann::json& document, const std::string& path, const ShapeLibrary& shapes);

}  // namespace opaline
