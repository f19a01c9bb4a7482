// Shapes a scene may name in place of a mesh file ("shape": "sphere"). The generators live in
// datasets_synthetic/shapes; a scene is loaded against a library of them.
#pragma once

#include "render/scene/json_object.h"
#include "render/scene/mesh.h"

#include <functional>
#include <map>
#include <string>

namespace opaline {

/// A shape by formula: reads its own keys from the object ("radius", "size", "triangles", ...),
/// in the scene's units, and returns a closed mesh with unit outward normals.
struct ShapeMaker {
  std::string summary;  ///< one line: keys, defaults, frame
  std::function<Mesh(JsonObject&)> make;
};
using ShapeLibrary = std::map<std::string, ShapeMaker>;

}  // namespace opaline
