#include "render/techniques/gather_technique.h"

#include "model/check.h"

#include <cmath>

namespace opaline {
namespace {

struct GatherObject {
  ClusterTree tree;
  ChannelProfiles profiles;
};

double largest_coordinate(const Mesh& mesh) {
  float largest = 0;
  for (const glm::vec3& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(p[axis]));
  return static_cast<double>(largest);
}

class PreparedGather : public PreparedTechnique {
 public:
  PreparedGather(const SharedScene& shared, const ProfileInfo& profile, const GatherSettings& settings)
      : shared_(shared), settings_(settings) {
    for (std::size_t i = 0; i < shared.scene.objects.size(); ++i) {
      const Object& object = shared.scene.objects[i];
      objects_.push_back({build_cluster_tree(shared.cells[i], shared.irradiance[i]),
                          ChannelProfiles(profile, shared.scene.materials[static_cast<std::size_t>(object.material)],
                                          1.01 * diameter(object.mesh), largest_coordinate(object.mesh))});
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    std::vector<glm::vec3> image(view.points.size(), glm::vec3(0)), bound;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(i));
      const std::vector<glm::vec3> exitance =
          gather_exitance(objects_[i].tree, shared_.cells[i], objects_[i].profiles, shared_.irradiance[i].colour,
                          points.positions, settings_, frame.counters, &bound);
      for (std::size_t k = 0; k < exitance.size(); ++k) frame.exitance[points.indices[k]] = exitance[k];
      for (std::size_t k = 0; k < bound.size(); ++k) image[points.indices[k]] = bound[k];
    }
    if (settings_.criterion == GatherSettings::Criterion::bound ||
        settings_.criterion == GatherSettings::Criterion::error)
      frame.images["bound"] = std::move(image);
    return frame;
  }

 private:
  const SharedScene& shared_;
  GatherSettings settings_;
  std::vector<GatherObject> objects_;
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_gather(const SharedScene& shared, const std::string& profile,
                                                  const GatherSettings& settings) {
  const ProfileInfo* info = find_profile(profile);
  OPALINE_CHECK(info);
  return std::make_unique<PreparedGather>(shared, *info, settings);
}

SettingSpec profile_setting() {
  const std::vector<std::string> names = medium_profile_names();
  return {"profile", names.front(), "diffusion profile R_d(r)", names};
}

std::string gather_not_applicable(const Scene&) { return {}; }

}  // namespace opaline
