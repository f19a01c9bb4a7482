// The shared parts of a scene in a file, so that a later run need not make them again.
#pragma once

#include "render/techniques/shared_scene.h"

#include <optional>
#include <string>

namespace opaline {

/// Meshes of the scene's objects and the shared parts made of them.
struct SceneParts {
  std::vector<Mesh> meshes;
  SharedParts shared;
  double load_seconds = 0;  ///< that loading the scene took when its meshes were made
};

/// Writes the file whole or not at all. The layout is this program's own: name files by program_hash().
void save_scene_parts(const std::string& path, const SceneParts& parts);

/// Nothing if there is no such file, or if it was cut or altered.
std::optional<SceneParts> load_scene_parts(const std::string& path);

}  // namespace opaline
