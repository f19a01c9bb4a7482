// Radiant exitance B at points of one object, by the hierarchical gather with a profile per channel.
#pragma once

#include "model/profiles/profile.h"
#include "render/irradiance/gather.h"
#include "render/irradiance/profile_bounds.h"
#include "render/irradiance/profile_sum.h"

#include <array>
#include <memory>

namespace opaline {

/// The profiles of one material, tabulated; channels with equal coefficients share a table.
class ChannelProfiles {
 public:
  /// r_max: largest distance between two points of the object; largest_coordinate: of any point of it [mm]
  /// (0: half of r_max), which says how exactly a float knows its place.
  ChannelProfiles(const ProfileInfo& info, const Material& material, double r_max, double largest_coordinate = 0);

  const ProfileSum& sum() const { return sum_; }
  int distinct() const { return sum_.table_count; }
  /// Of each table for one flux channel, of each colour channel for three.
  const ProfileBounds& bounds(int flux_channels) const { return flux_channels == 1 ? bounds_ : channel_bounds_; }
  const Profile& profile(int channel) const { return *profiles_[static_cast<std::size_t>(channel)]; }

 private:
  std::array<std::unique_ptr<Profile>, 3> profiles_;
  std::vector<ProfileTable> tables_;
  ProfileSum sum_;
  ProfileBounds bounds_, channel_bounds_;
};

/// Which clusters may stand for their cells.
struct GatherSettings {
  enum class Criterion {
    bound,        ///< a rigorous bound of the error against max_relative_error
    error,        ///< an estimate of the error, made from the bound, against max_relative_error
    solid_angle,  ///< Jensen & Buhler 2002: area / distance^2 < quality, point clusters, no near field
    none,         ///< no clusters at all: every cell is summed (all_pairs.h); max_relative_error is the cell_error
  };
  Criterion criterion = Criterion::error;
  /// Of B in every channel, or of 1e-3 of the mean lit irradiance where B is darker.
  double max_relative_error = 1e-3;
  double quality = 0.2;
};

/// Largest distance between two corners of a mesh's bounding box [mm].
double diameter(const Mesh& mesh);

/// B at each point [units of irradiance]; counts are added to `counters`. `bound` gets, with criteria bound and error,
/// how far B may be from the sum over all cells taken exactly (irradiance.md); done["queries_over_tolerance"] counts
/// the points where that is more than was asked.
std::vector<glm::vec3> gather_exitance(const ClusterTree& tree, const SurfaceCells& cells,
                                       const ChannelProfiles& profiles, const Rgb& light_colour,
                                       std::span<const glm::vec3> points, const GatherSettings& settings,
                                       Counters& counters, std::vector<glm::vec3>* bound = nullptr);

}  // namespace opaline
