#include "render/input_error.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace opaline {

#define OPALINE_ROW(name) Technique name##_technique();
#include "technique_registry.inc"
#undef OPALINE_ROW

const std::vector<Technique>& techniques() {
  static const std::vector<Technique> all = {
#define OPALINE_ROW(name) name##_technique(),
#include "technique_registry.inc"
#undef OPALINE_ROW
  };
  return all;
}

MaterialKind kind_of(const Material& material) {
  if (material.layers) return MaterialKind::layered;
  return material.textured() ? MaterialKind::textured : MaterialKind::homogeneous;
}

std::string name_of(MaterialKind kind) {
  return kind == MaterialKind::layered ? "layered" : kind == MaterialKind::textured ? "textured" : "homogeneous";
}

std::string why_not_applicable(const Technique& technique, const Scene& scene) {
  const auto takes = [&](MaterialKind kind) {
    return std::find(technique.materials.begin(), technique.materials.end(), kind) != technique.materials.end();
  };
  for (const Object& object : scene.objects) {
    const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
    if (takes(kind_of(material))) continue;
    if (material.layers)
      return fmt::format("material '{}' has layers, and it takes a medium without them", material.name);
    if (material.textured())
      return fmt::format("material '{}' has maps, and it takes one coefficient for all of a surface", material.name);
    return fmt::format("material '{}' is homogeneous, and it takes {} ones", material.name,
                       name_of(technique.materials.front()));
  }
  return technique.not_applicable(scene);
}

const Technique& find_technique(const std::string& name) {
  std::vector<std::string> names;
  for (const Technique& technique : techniques()) {
    if (technique.name == name) return technique;
    names.push_back(technique.name);
  }
  throw InputError("--technique", "", fmt::format("'{}' is not one of {}", name, fmt::join(names, ", ")));
}

}  // namespace opaline
