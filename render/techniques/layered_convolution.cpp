// Planes parallel to the film that light is splatted onto, convolved between, and looked up from.
#include "render/layered/layered_convolution.h"

#include "render/techniques/gather_technique.h"

namespace opaline {
namespace {

class PreparedLayers : public PreparedTechnique {
 public:
  PreparedLayers(const SharedScene& shared, const LayeredSettings& settings)
      : shared_(shared), settings_(settings), objects_(layered_objects(shared.scene, settings)) {}

  Frame render(const GBuffer& view) const override {
    LayeredCpu backend;
    return render_layered(shared_, objects_, settings_, view, backend);
  }

 private:
  const SharedScene& shared_;
  LayeredSettings settings_;
  std::vector<LayeredObject> objects_;
};

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return std::make_unique<PreparedLayers>(shared, read_layered_settings(settings));
}

}  // namespace

Technique layered_convolution_technique() {
  return {.name = "layered_convolution",
          .summary = "light splatted onto planes parallel to the film, convolved between them by Fourier transforms",
          .citation =
              "Munoz, Echevarria, Seron, Gutierrez 2011, \"Convolution-Based Simulation of Homogeneous "
              "Subsurface Scattering\"",
          .backends = {"cpu", "gpu"},
          .limits =
              "any scene; layers and film set its error, which is largest where the surface is steep, thin or "
              "sharp against the layers' gaps",
          .settings = layered_setting_specs(),
          .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
          .not_applicable = gather_not_applicable,
          .prepare = prepare,
          .prepare_gpu = prepare_layered_convolution_gl,
          .twin_tolerance = 1e-4};
}

}  // namespace opaline
