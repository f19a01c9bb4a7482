// One scene of a suite, ready to be measured: what all its cells share, made once and kept in files.
#pragma once

#include "render/techniques/technique.h"
#include "validate/cells.h"
#include "validate/record.h"

#include <memory>
#include <optional>
#include <string>

namespace opaline {

/// An image that errors are measured against, with its file and what is known of its own error.
struct ReferenceImage {
  Image image;
  std::string file;                          ///< relative to the folder of the records
  std::string error_file;                    ///< of its "bound" or "variance", relative as well
  double relative_error = 0, max_error = 0;  ///< RMS of bound or standard error / RMS of the image; largest bound
  double seconds = 0;
  SettingValues settings;  ///< of the hierarchical reference
};

class MeasuredScene {
 public:
  /// Loads the scene and makes or reads its shared parts. `folder`: that of the records; DIR/cache, DIR/images and
  /// DIR/scenes are used in it. Throws InputError for a scene that cannot be loaded.
  MeasuredScene(const Suite& suite, const SceneCase& scene, const ShapeLibrary& shapes, const std::string& folder);

  Scene scene;                          ///< edits change it and put it back
  std::unique_ptr<SharedScene> shared;  ///< with irradiance
  double load_seconds = 0;
  std::string scene_file;  ///< relative to the folder: what `opaline render` can be given

  /// Which technique the others are judged by: hierarchical, or single_scatter_exact for materials with layers; empty
  /// where neither can render the scene.
  std::string reference_technique() const;
  /// Its image: hierarchical with the suite's tight settings and that profile. Made when first asked for.
  const ReferenceImage& reference(const std::string& profile);
  /// Transport truth; null where the suite doesn't ask for it or the scene doesn't allow it.
  const ReferenceImage* truth();
  /// Seconds spent on references and truth so far, and not read from files.
  double reference_seconds() const { return made_seconds_; }

 private:
  ReferenceImage make(const std::string& technique, const SettingValues& settings, const char* error_layer);
  ReferenceImage find_or_make(const std::string& technique, const SettingValues& settings, const char* error_layer);
  const Suite& suite_;
  const SceneCase& case_;
  std::string folder_;
  std::map<std::string, ReferenceImage> references_;
  std::optional<ReferenceImage> truth_;
  double made_seconds_ = 0;
};

}  // namespace opaline
