// Transfer kept at vertices for a set of light directions: a relit frame is a weighted sum of a few rows.
#include "render/techniques/gather_technique.h"
#include "render/transfer/transfer_scene.h"

#include <tbb/parallel_for.h>

namespace opaline {
namespace {

class PreparedTransfer : public PreparedTechnique {
 public:
  PreparedTransfer(const SharedScene& shared, const TransferSettings& settings)
      : shared_(shared), transfer_(make_transfer_scene(shared, settings)), exitance_(transfer_.objects.size()) {}

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    frame.counters += transfer_.counters;
    for (std::size_t i = 0; i < transfer_.objects.size(); ++i) {
      const TransferObject& object = transfer_.objects[i];
      VertexExitance& b = exitance_[i];
      object.transfer.exitance(transfer_.lights(shared_, i), object.nodes, b, frame.counters);
      const PointPlaces points = places_of_object(shared_, transfer_, view, i);
      for (std::size_t k = 0; k < points.indices.size(); ++k)
        frame.exitance[points.indices[k]] = interpolated(points.places[k], [&](std::uint32_t v) {
          return glm::vec3(b.channel[0][v], b.channel[1][v], b.channel[2][v]);
        });
    }
    return frame;
  }

 private:
  const SharedScene& shared_;
  TransferScene transfer_;
  mutable std::vector<VertexExitance> exitance_;  ///< of the last frame, whose memory the next one takes
};

std::unique_ptr<PreparedTechnique> prepare(const SharedScene& shared, const Settings& settings) {
  return std::make_unique<PreparedTransfer>(shared, read_transfer_settings(settings));
}

}  // namespace

Technique precomputed_transfer_technique() {
  return {.name = "precomputed_transfer",
          .summary = "what vertices get from each of a set of light directions, precomputed; relit by interpolation",
          .citation = "Hao, Varshney 2004, \"Real-Time Rendering of Translucent Meshes\"",
          .backends = {"cpu", "gpu"},
          .limits =
              "directional, point and environment lights, no projectors, no point light close to the object; exitance "
              "is interpolated between vertices; with lights=any an edit of the lights needs no new table",
          .settings = transfer_setting_specs(),
          .invalidated_by = {.camera = false, .light = true, .material = true, .geometry = true},
          .not_applicable = transfer_not_applicable,
          .prepare = prepare,
          .needs_irradiance = false,
          .prepare_gpu = prepare_transfer_gl,
          .twin_tolerance = 2e-3};
}

}  // namespace opaline
