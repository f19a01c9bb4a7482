#include "render/techniques/gather_technique.h"

#include "model/check.h"

#include <cmath>

namespace opaline {
namespace {

struct GatherObject {
  ChannelProfiles profiles;
  std::unique_ptr<GatherSurface> surface;
};

double largest_coordinate(const Mesh& mesh) {
  float largest = 0;
  for (const glm::vec3& p : mesh.positions)
    for (int axis = 0; axis < 3; ++axis) largest = std::max(largest, std::abs(p[axis]));
  return static_cast<double>(largest);
}

class PreparedGather : public PreparedTechnique {
 public:
  PreparedGather(const SharedScene& shared, const ProfileInfo& profile, const GatherChoice& choice)
      : shared_(shared), settings_(choice.clusters) {
    for (std::size_t i = 0; i < shared.scene.objects.size(); ++i) {
      const Object& object = shared.scene.objects[i];
      ChannelProfiles profiles(profile, shared.scene.materials[static_cast<std::size_t>(object.material)],
                               1.01 * diameter(object.mesh), largest_coordinate(object.mesh));
      auto surface = gather_surface(shared, i, profiles, choice, counters_);
      if (choice.discretisation_error > 0) error_ = std::max(error_, surface->own.error);
      objects_.push_back({std::move(profiles), std::move(surface)});
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.counters = counters_;
    if (error_ >= 0) frame.estimates["discretisation_error"] = error_;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    std::vector<glm::vec3> image(view.points.size(), glm::vec3(0)), bound;
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(i));
      const GatherSurface& surface = *objects_[i].surface;
      const std::vector<glm::vec3> exitance =
          gather_exitance(surface.own.tree, *surface.cells, objects_[i].profiles, shared_.irradiance[i].colour,
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
  Counters counters_;  ///< of the preparation
  double error_ = -1;  ///< estimated, of the discretisation; below 0: it wasn't looked at
  std::vector<GatherObject> objects_;
};

}  // namespace

std::unique_ptr<GatherSurface> gather_surface(const SharedScene& shared, std::size_t object,
                                              const ChannelProfiles& profiles, const GatherChoice& choice,
                                              Counters& counters) {
  auto surface = std::make_unique<GatherSurface>();
  surface->cells = &shared.cells[object];
  if (choice.discretisation_error <= 0) {
    surface->own.tree = build_cluster_tree(shared.cells[object], shared.irradiance[object]);
    return surface;
  }
  DiscretisationSettings settings;
  settings.max_relative_error = choice.discretisation_error;
  surface->own = discretise(shared.scene, shared.rays, object, shared.cells[object], shared.irradiance[object],
                            profiles, shared.settings.irradiance, settings, counters);
  surface->cells = &surface->own.cells;
  return surface;
}

std::unique_ptr<PreparedTechnique> prepare_gather(const SharedScene& shared, const GatherChoice& choice) {
  const ProfileInfo* info = find_profile(choice.profile);
  OPALINE_CHECK(info);
  return std::make_unique<PreparedGather>(shared, *info, choice);
}

SettingSpec profile_setting() {
  const std::vector<std::string> names = medium_profile_names();
  return {"profile", names.front(), "diffusion profile R_d(r)", names};
}

std::string gather_not_applicable(const Scene&) { return {}; }

}  // namespace opaline
