// The cells of a suite: which scene, technique, backend and settings are measured, and by what each is known.
#pragma once

#include "render/techniques/technique.h"
#include "validate/suite.h"

#include <string>
#include <vector>

namespace opaline {

/// A scene of a suite with one material.
struct SceneCase {
  std::string name, material;
  std::string path;         ///< anchors relative paths
  nlohmann::json document;  ///< a scene document with that material; its paths are absolute
  std::string hash;         ///< of the document and of the files it names
};

/// Another renderer: a command whose {scene} and {out} stand for a scene file and the EXR it must write.
struct ExternalTechnique {
  std::string name, command;
};

/// Reads NAME=COMMAND; InputError (--external) for another form or a command without {scene} and {out}.
ExternalTechnique parse_external(const std::string& text);

struct Cell {
  std::size_t scene = 0;                 ///< index of its SceneCase
  const Technique* technique = nullptr;  ///< null: an external one
  std::string name, backend;             ///< of the technique; "cpu", "gpu", "external"
  SettingValues settings;                ///< those of the sweep
  std::string command;                   ///< of an external technique
  std::string hash;                      ///< of everything that determines what is measured
};

/// What of a suite is run, and what beside it. Empty lists: all.
struct CellChoice {
  std::vector<std::string> scenes, techniques, backends;
  std::vector<ExternalTechnique> externals;
  std::string gl;   ///< which GL the gpu backend uses, as RenderOptions::gl
  int threads = 0;  ///< how many are used; 0: all processors
};

/// One case for each scene and material. Throws InputError for a name in `choice` that the suite lacks.
std::vector<SceneCase> scene_cases(const Suite& suite, const CellChoice& choice);

/// Scene by scene, and in each technique by technique in the order of the registry. A technique without a backend of
/// the suite's has a cell there all the same, which is not applicable.
std::vector<Cell> enumerate_cells(const Suite& suite, const std::vector<SceneCase>& cases, const CellChoice& choice);

}  // namespace opaline
