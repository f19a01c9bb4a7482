// The contract of a rendering technique, and the registry of all of them.
//
// A technique is one <name>.cpp in this folder and one line in CMakeLists.txt.
//
//   prepare   everything that survives an edit of the camera
//   render    one frame of a view: radiant exitance B at its visible points, or their radiance
//
// Exitance gets its exit lobe F_t / (pi c) from `shade`, the same for every technique. A technique that
// follows light through the boundary itself returns the radiance, and no lobe is applied.
#pragma once

#include "render/image.h"
#include "render/techniques/settings.h"
#include "render/techniques/shared_scene.h"

#include <map>
#include <memory>
#include <string>
#include <vector>

namespace opaline {

namespace gl {
class Context;
}

/// Which edits of the scene need prepare again.
struct InvalidatedBy {
  bool camera = false, light = false, material = false, geometry = false;
};

/// What the materials of a scene are made of: the same all over, with maps over the surface, or of layers below it.
enum class MaterialKind { homogeneous, textured, layered };
MaterialKind kind_of(const Material& material);
std::string name_of(MaterialKind kind);

/// Everything per visible point of the view. Either `exitance` or `radiance` is filled, the other is empty.
struct Frame {
  std::vector<glm::vec3> exitance;  ///< B [irradiance]
  Counters counters;
  std::vector<glm::vec3> radiance;  ///< L_o
  /// What else the technique knows of its result, by name, in the units of what it returns; beside
  /// exitance it gets the same exit lobe. Names in use:
  ///   variance  beside radiance: squared standard error of each value [radiance^2]
  ///   error     estimate of the error of each value: what the last refinement changed
  ///   bound     no value is further than this from what the technique approximates
  std::map<std::string, std::vector<glm::vec3>> images;
  /// What it knows of the whole result, by name. In use:
  ///   discretisation_error  of a surface cut into cells, relative RMS of the exitance
  std::map<std::string, double> estimates{};
  std::vector<std::string> notes;  ///< what the technique picked by itself, a sentence each
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
  /// Empty if it can render the scene's shapes and lights, else the reason why not.
  std::string (*not_applicable)(const Scene& scene);
  /// The shared scene must outlive the result.
  std::unique_ptr<PreparedTechnique> (*prepare)(const SharedScene& shared, const Settings& settings);
  /// Does prepare read the cells and their irradiance? If not they aren't made.
  bool needs_irradiance = true;
  /// An estimate of transport itself, by chance: no diffusion profile, and the frame has a "variance".
  bool statistical = false;
  /// Misses light that enters the surface where its views don't look: right where all lit surface is seen.
  bool only_visible = false;
  /// The GPU's twin of prepare, if backends has "gpu". The context must outlive the result.
  std::unique_ptr<PreparedTechnique> (*prepare_gpu)(const SharedScene& shared, const Settings& settings,
                                                    const gl::Context& context) = nullptr;
  /// Most that the twins differ, fed the same scene and view: RMS of the difference over the RMS of the value.
  double twin_tolerance = 0;
  /// The materials it can render.
  std::vector<MaterialKind> materials = {MaterialKind::homogeneous};
};

/// Empty if the technique can render the scene with these materials, else the reason why not: what to ask, as it
/// includes the technique's own not_applicable.
std::string why_not_applicable(const Technique& technique, const Scene& scene);

/// All registered techniques, in the order of CMakeLists.txt.
const std::vector<Technique>& techniques();

/// The technique of that name; InputError naming the valid ones if there is none.
const Technique& find_technique(const std::string& name);

/// L_o = F_t(eta, w_o) B / (pi c) per pixel, as R, G, B and A (1 where an object is seen).
Image shade(const Scene& scene, const GBuffer& view, const std::vector<glm::vec3>& exitance,
            ExitLobe lobe = ExitLobe::normalised);

/// The frame's radiance per pixel as R, G, B and A, whichever of the two it holds.
Image shade(const Scene& scene, const GBuffer& view, const Frame& frame, ExitLobe lobe = ExitLobe::normalised);

/// The frame's other images, R, G and B of radiance (or its square), 0 where no object is seen.
std::map<std::string, Image> shade_layers(const Scene& scene, const GBuffer& view, const Frame& frame,
                                          ExitLobe lobe = ExitLobe::normalised);

}  // namespace opaline
