#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/scene_parts.h"
#include "render/scene/texture_coordinates.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// p -> translate + rotate (scale p), in scene units.
struct Transform {
  glm::dvec3 scale{1}, translate{0};
  glm::dmat3 rotate{1};
};

/// Turns about x first, then y, then z (fixed axes).
glm::dmat3 rotation(const glm::dvec3& deg) {
  const glm::dvec3 angle = deg * (pi / 180);
  const glm::dvec3 c = glm::cos(angle), s = glm::sin(angle);
  const glm::dmat3 x(1, 0, 0, 0, c.x, s.x, 0, -s.x, c.x);
  const glm::dmat3 y(c.y, 0, -s.y, 0, 1, 0, s.y, 0, c.y);
  const glm::dmat3 z(c.z, s.z, 0, -s.z, c.z, 0, 0, 0, 1);
  return z * y * x;
}

Transform read_transform(JsonObject json) {
  Transform transform;
  transform.translate = json.vec3_or("translate", Range::any(), glm::dvec3(0));
  transform.rotate = rotation(json.vec3_or("rotate_deg", Range::any(), glm::dvec3(0)));
  if (json.has("scale")) transform.scale = json.rgb("scale", Range::positive());
  json.finish();
  return transform;
}

void apply(const Transform& transform, double mm_per_unit, Mesh& mesh) {
  for (glm::vec3& p : mesh.positions) {
    p = (transform.translate + transform.rotate * (transform.scale * glm::dvec3(p))) * mm_per_unit;
  }
  for (glm::vec3& n : mesh.normals) n = glm::normalize(transform.rotate * (glm::dvec3(n) / transform.scale));
}

std::vector<std::string> names_of(const ShapeLibrary& shapes) {
  std::vector<std::string> names;
  for (const auto& [name, maker] : shapes) names.push_back(name);
  return names;
}

Mesh make_shape(JsonObject& json, const ShapeLibrary& shapes) {
  const std::string name = json.text("shape");
  const auto it = shapes.find(name);
  if (it == shapes.end()) json.fail("shape", unknown_choice("shape", name, names_of(shapes)));
  return it->second.make(json);
}

/// "texture_coordinates": those of the file, or made.
enum class UvSource { any, file, planar, cylindrical, spherical };

UvSource read_uv_source(JsonObject& json) {
  const std::vector<std::string> words = {"any", "file", "planar", "cylindrical", "spherical"};
  if (!json.has("texture_coordinates")) return UvSource::any;
  const std::string word = json.choice("texture_coordinates", {words.begin() + 1, words.end()});
  return static_cast<UvSource>(std::find(words.begin(), words.end(), word) - words.begin());
}

/// Coordinates where they are asked for or needed. Shapes have none of their own: theirs are planar unless said.
void give_texture_coordinates(UvSource source, bool is_shape, const Material& material, const std::string& file,
                              Mesh& mesh) {
  if (source == UvSource::any && !material.needs_uvs()) return;
  if (source == UvSource::any && is_shape && mesh.uvs.empty()) source = UvSource::planar;
  if (source == UvSource::any || source == UvSource::file) {
    if (!mesh.uvs.empty()) return;
    throw InputError(file, "",
                     "has no texture coordinates, which material \"" + material.name +
                         "\" needs; add them to the mesh, or set \"texture_coordinates\" to \"planar\", "
                         "\"cylindrical\" or \"spherical\"");
  }
  make_texture_coordinates(mesh, source == UvSource::planar        ? UvProjection::planar
                                 : source == UvSource::cylindrical ? UvProjection::cylindrical
                                                                   : UvProjection::spherical);
}

/// The key that says where the surface comes from: exactly one of the two.
std::string source_key(JsonObject& json) {
  const bool mesh = json.has("mesh"), shape = json.has("shape");
  if (mesh == shape) {
    throw InputError(json.file(), json.pointer(),
                     "needs exactly one of \"mesh\" (a file) and \"shape\" (a name); it has " +
                         std::string(mesh ? "both" : "neither"));
  }
  return mesh ? "mesh" : "shape";
}

}  // namespace

Object read_object(JsonObject json, const SceneContext& context, std::vector<Material>& materials,
                   std::size_t& dropped) {
  Object object;
  const std::string key = source_key(json);
  object.name = json.text(key);
  object.material = find_or_add_material(json, materials);
  const Transform transform = json.has("transform") ? read_transform(json.object("transform")) : Transform{};
  const bool drop = json.choice_or("zero_area_triangles", {"reject", "drop"}, "reject") == "drop";
  const UvSource uvs = read_uv_source(json);
  if (key == "shape") object.mesh = make_shape(json, context.shapes);
  json.finish();
  const std::string file = key == "mesh" ? context.resolve(object.name) : object.name;
  load_for_key(json, key, [&] {
    if (key == "mesh") object.mesh = load_mesh(file);
    give_texture_coordinates(uvs, key == "shape", materials[static_cast<std::size_t>(object.material)], file,
                             object.mesh);
    apply(transform, context.mm_per_unit, object.mesh);
    dropped += validate_mesh(object.mesh, drop ? ZeroAreaTriangles::drop : ZeroAreaTriangles::reject, file, "");
  });
  return object;
}

}  // namespace opaline
