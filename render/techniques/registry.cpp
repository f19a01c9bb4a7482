#include "render/input_error.h"
#include "render/techniques/technique.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

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

const Technique& find_technique(const std::string& name) {
  std::vector<std::string> names;
  for (const Technique& technique : techniques()) {
    if (technique.name == name) return technique;
    names.push_back(technique.name);
  }
  throw InputError("--technique", "", fmt::format("'{}' is not one of {}", name, fmt::join(names, ", ")));
}

}  // namespace opaline
