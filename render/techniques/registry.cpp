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

std::string why_not_applicable(const Technique& technique, const Scene& scene) {
  const auto takes = [&](MaterialKind kind) {
    return std::find(technique.materials.begin(), technique.materials.end(), kind) != technique.materials.end();
  };
  for (const Object& object : scene.objects) {
    const Material& material = scene.materials[static_cast<std::size_t>(object.material)];
    if (material.textured() && !takes(MaterialKind::textured))
      return fmt::format("material '{}' has maps, and it takes one coefficient for all of a surface", material.name);
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
