#include "render/choices.h"
#include "render/input_error.h"
#include "render/scene/scene_parts.h"

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
  if (key == "shape") object.mesh = make_shape(json, context.shapes);
  json.finish();
  const std::string file = key == "mesh" ? context.resolve(object.name) : object.name;
  load_for_key(json, key, [&] {
    if (key == "mesh") object.mesh = load_mesh(file);
    apply(transform, context.mm_per_unit, object.mesh);
    dropped += validate_mesh(object.mesh, drop ? ZeroAreaTriangles::drop : ZeroAreaTriangles::reject, file, "");
  });
  return object;
}

}  // namespace opaline
