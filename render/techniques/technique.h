// The contract of a rendering technique, and the registry of all of them.
//
// A technique is one <name>.cpp in this folder and one line in CMakeLists.txt.
//
//   prepare   everything that survives an edit of the camera
//   render    one frame: radiant exitance B at every visible point of the view
//
// The exit lobe F_t / (pi c) is applied by `shade`, the same for every technique.
#pragma once

#include "render/image.h"
#include "render/techniques/settings.h"
#include "render/techniques/shared_scene.h"

#include <memory>
#include <string>
#include <vector>

namespace opaline {

/// Which edits of the scene need prepare again.
struct InvalidatedBy {
  bool camera = false, light = false, material = false, geometry = false;
};

struct Frame {
  std::vector<glm::vec3> exitance;  ///< B per visible point [irradiance]
  Counters counters;
};

class PreparedTechnique {
 public:
  virtual ~PreparedTechnique() = default;
  virtual Frame render(const GBuffer& view) const = 0;
};

struct Technique {
  std::string name, summary, citation;
  std::vector<std::string> backends;  ///< "cpu", "gpu"
  std::string limits;                 ///< what it needs and what it cannot do
  std::vector<SettingSpec> settings;
  InvalidatedBy invalidated_by;
  /// Empty if it can render the scene, else the reason why not.
  std::string (*not_applicable)(const Scene& scene);
  /// The shared scene must outlive the result.
  std::unique_ptr<PreparedTechnique> (*prepare)(const SharedScene& shared, const Settings& settings);
};

/// All registered techniques, in the order of CMakeLists.txt.
const std::vector<Technique>& techniques();

/// The technique of that name; InputError naming the valid ones if there is none.
const Technique& find_technique(const std::string& name);

/// L_o = F_t(eta, w_o) B / (pi c) per pixel, as R, G, B and A (1 where an object is seen).
Image shade(const Scene& scene, const GBuffer& view, const std::vector<glm::vec3>& exitance,
            ExitLobe lobe = ExitLobe::normalised);

}  // namespace opaline
