// Radiant exitance B at points of one object, by the hierarchical gather with a profile per channel.
#pragma once

#include "model/profiles/profile.h"
#include "render/irradiance/gather.h"
#include "render/irradiance/profile_sum.h"

#include <array>
#include <memory>

namespace opaline {

/// The profiles of one material, tabulated; channels with equal coefficients share a table.
class ChannelProfiles {
 public:
  /// r_max: largest distance between two points of the object [mm].
  ChannelProfiles(const ProfileInfo& info, const Material& material, double r_max);

  const ProfileSum& sum() const { return sum_; }
  int distinct() const { return sum_.table_count; }
  /// Length over which any of the profiles changes, as an inverse [1/mm], at distance r.
  float inverse_scale(float r) const { return inverse_scale_(r * r); }
  float core_radius() const { return core_radius_; }  ///< of the narrowest profile [mm]
  const Profile& profile(int channel) const { return *profiles_[static_cast<std::size_t>(channel)]; }

 private:
  std::array<std::unique_ptr<Profile>, 3> profiles_;
  std::vector<ProfileTable> tables_;
  ProfileTable inverse_scale_;
  ProfileSum sum_;
  float core_radius_ = 0;
};

/// Which clusters may stand for their cells.
struct GatherSettings {
  enum class Criterion {
    error,        ///< estimated error against max_relative_error
    solid_angle,  ///< Jensen & Buhler 2002: area / distance^2 < quality, point clusters, no near field
    none,         ///< no clusters at all: every cell is summed (all_pairs.h); max_relative_error is the cell_error
  };
  Criterion criterion = Criterion::error;
  double max_relative_error = 1e-3;  ///< of B, or of 1e-3 of the mean lit irradiance where B is darker
  double quality = 0.2;
};

/// Largest distance between two corners of a mesh's bounding box [mm].
double diameter(const Mesh& mesh);

/// B at each point [units of irradiance]; counts are added to `counters`.
std::vector<glm::vec3> gather_exitance(const ClusterTree& tree, const SurfaceCells& cells,
                                       const ChannelProfiles& profiles, const Rgb& light_colour,
                                       std::span<const glm::vec3> points, const GatherSettings& settings,
                                       Counters& counters);

}  // namespace opaline
