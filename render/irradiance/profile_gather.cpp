#include "render/irradiance/profile_gather.h"

#include "model/check.h"
#include "render/irradiance/all_pairs.h"

#include <cmath>

namespace opaline {
namespace {

// Remainder of the two-point rule, as a fraction of flux * R: the third moment, times (size / scale)^3, and
// for a query beside the patch what var |delta|^2 lacks of a disk's, times (trace / distance^2)^2. Fitted so
// that the RMS error of a picture stays below the tolerance (tests/render).
constexpr float third_remainder = 0.003f, fourth_remainder = 0.3f;

/// Largest (radius / distance)^2 of an accepted patch.
constexpr float max_opening = 0.5f;

/// -d ln R / dr at r by a central difference in ln R.
double log_slope(const Profile& profile, double r) {
  const double h = 1e-4 * r, below = profile.evaluate(r - h), above = profile.evaluate(r + h);
  return above > 0 && below > 0 ? std::log(below / above) / (2 * h) : 0;
}

/// Adds the sums of one query's patches.
struct ExitanceSink {
  const ProfileSum& profile;
  std::vector<std::array<float, 3>>& sums;
  std::size_t query = 0;
  glm::vec3 position{0};

  void begin(std::size_t q, const glm::vec3& p) { query = q, position = p; }
  void add(const PatchList& patches, const float* weight) {
    add_profile_sum(profile, patches, weight, position, sums[query].data());
  }
  void end() {}
};

/// A cluster is accepted when its estimated error is a small part of its own contribution, or of
/// the flux-proportional share of the group's whole exitance. The shares add up to the whole, so the
/// errors stay below twice the tolerance as far as the estimates hold.
struct ErrorCriterion {
  static constexpr float moments = 1;
  const ClusterTree& tree;
  const ChannelProfiles& profiles;
  float tolerance;
  bool clusters;       ///< false: only leaves are judged
  float core_squared;  ///< of the narrowest profile [mm^2]
  float floor;         ///< exitance below which a pixel counts as dark, per unit of total flux
  float group_radius = 0;
  float average[3] = {0, 0, 0};  ///< per table: estimated B / total flux at the group's centre

  void begin_group(const glm::vec3& centre, float radius) {
    group_radius = radius;
    for (int t = 0; t < profiles.sum().table_count; ++t)
      average[t] = std::max(floor, 0.5f * estimate(centre, *profiles.sum().tables[t]));
  }

  /// Coarse B per unit of flux at a point: clusters as points, opened while they look large.
  float estimate(const glm::vec3& p, const ProfileTable& table) const {
    float sum = 0, total = 0;
    for (int m = 0; m < tree.masses; ++m) total += tree.mass[static_cast<std::size_t>(m)];
    for (std::size_t i = 0; i < tree.nodes.size();) {
      const ClusterNode& node = tree.nodes[i];
      const glm::vec3 d = node.centroid - p;
      const float r2 = glm::dot(d, d) + node.trace();
      const bool use = node.cell != ClusterNode::no_cell || 3 * node.radius * node.radius < r2;
      if (use)
        for (int m = 0; m < tree.masses; ++m)
          sum += tree.mass[i * static_cast<std::size_t>(tree.masses) + static_cast<std::size_t>(m)] * table(r2);
      i = use ? node.skip : i + 1;
    }
    return total > 0 ? sum / total : 0;
  }

  bool acceptable(float distance, float radius, float trace) const {
    // The expansion needs the patch to be small against the distance, or against the flat core.
    if (radius * radius > max_opening * (distance * distance + core_squared)) return false;
    const float s = profiles.inverse_scale(distance), w = trace / (distance * distance + core_squared);
    const float error = third_remainder * s * s * s * radius * trace + fourth_remainder * w * w;
    if (error <= tolerance) return true;
    for (int t = 0; t < profiles.sum().table_count; ++t)
      if ((*profiles.sum().tables[t])(distance * distance) * error > tolerance * average[t]) return false;
    return true;
  }
  bool accept(const ClusterNode& node, float distance) const {
    if (!clusters && node.cell == ClusterNode::no_cell) return false;
    return acceptable(std::max(0.0f, distance - group_radius), node.radius, node.trace());
  }
  bool accept_part(float distance, float radius, float trace) const { return acceptable(distance, radius, trace); }
};

/// The published test: the node looks small and the point is outside it. Leaves are points.
struct SolidAngleCriterion {
  static constexpr float moments = 0;
  float quality;
  void begin_group(const glm::vec3&, float) {}
  bool accept(const ClusterNode& node, float distance) const {
    return node.cell != ClusterNode::no_cell || (distance > node.radius && node.area < quality * distance * distance);
  }
  bool accept_part(float, float, float) const { return true; }
};

/// A thousandth of the mean irradiance of the lit cells, per unit of total flux: 1e-3 / lit area.
float dark_level(const ClusterTree& tree) { return 1e-3f / tree.nodes.front().area; }

template <typename Criterion>
GatherCounts run(const ClusterTree& tree, const SurfaceCells& cells, const ChannelProfiles& profiles,
                 std::span<const glm::vec3> points, const Criterion& criterion, std::size_t group_size,
                 std::vector<std::array<float, 3>>& sums) {
  return gather(
      tree, cells, points, [&] { return criterion; },
      [&] {
        return ExitanceSink{profiles.sum(), sums};
      },
      group_size);
}

void count(const GatherCounts& c, const ClusterTree& tree, const ChannelProfiles& profiles, std::size_t points,
           Counters& counters) {
  counters.done["queries"] += points;
  counters.done["nodes_visited"] += c.nodes_visited;
  counters.done["clusters"] += c.clusters;
  counters.done["near_cells"] += c.near_cells;
  counters.done["cell_parts"] += c.cell_parts;
  counters.done["channels"] += static_cast<std::uint64_t>(profiles.distinct());
  counters.skipped["equal_channels"] += 3 - static_cast<std::uint64_t>(profiles.distinct());
  counters.skipped["dark_cells"] += tree.dark_cells;
  counters.skipped["cell_splits_at_depth_limit"] += c.depth_limit_reached;
}

}  // namespace

double diameter(const Mesh& mesh) {
  glm::vec3 lo(mesh.positions.front()), hi(lo);
  for (const glm::vec3& p : mesh.positions) lo = glm::min(lo, p), hi = glm::max(hi, p);
  return glm::length(glm::dvec3(hi) - glm::dvec3(lo));
}

ChannelProfiles::ChannelProfiles(const ProfileInfo& info, const Material& material, double r_max) {
  double core = r_max;
  std::vector<int> owner;  // channel whose profile each table holds
  for (int c = 0; c < 3; ++c) {
    profiles_[static_cast<std::size_t>(c)] = info.make(material.channel(c));
    int table = 0;
    while (table < static_cast<int>(owner.size()) &&
           (material.sigma_a[owner[static_cast<std::size_t>(table)]] != material.sigma_a[c] ||
            material.sigma_s_prime[owner[static_cast<std::size_t>(table)]] != material.sigma_s_prime[c]))
      ++table;
    if (table == static_cast<int>(owner.size())) owner.push_back(c);
    sum_.table_of[c] = table;
    core = std::min(core, profile(c).core_radius());
  }
  core_radius_ = static_cast<float>(core);
  sum_.table_count = static_cast<int>(owner.size());
  tables_.reserve(owner.size());
  for (const int c : owner) {
    const Profile& p = profile(c);
    tables_.emplace_back([&p](double r) { return p.evaluate(r); }, core, r_max);  // one core: same segments
    sum_.tables[tables_.size() - 1] = &tables_.back();
  }
  inverse_scale_ = ProfileTable(
      [&](double r) {
        double steepest = 0;
        for (const int c : owner) {
          const double slope = r > 0 ? log_slope(profile(c), r) : 0, z = profile(c).core_radius();
          steepest = std::max(steepest, std::sqrt(slope * slope + 1 / (r * r + z * z)));
        }
        return steepest;
      },
      core, r_max);
}

std::vector<glm::vec3> gather_exitance(const ClusterTree& tree, const SurfaceCells& cells,
                                       const ChannelProfiles& profiles, const Rgb& light_colour,
                                       std::span<const glm::vec3> points, const GatherSettings& settings,
                                       Counters& counters) {
  OPALINE_CHECK(tree.masses == 1 || tree.masses == 3);
  std::vector<std::array<float, 3>> sums(points.size(), {0, 0, 0});
  GatherCounts counts;
  if (!tree.nodes.empty() && settings.criterion == GatherSettings::Criterion::solid_angle) {
    const SolidAngleCriterion criterion{static_cast<float>(settings.quality)};
    counts = run(tree, cells, profiles, points, criterion, 1, sums);
  } else if (!tree.nodes.empty()) {
    const bool clusters = settings.criterion == GatherSettings::Criterion::error;
    const ErrorCriterion criterion{tree,
                                   profiles,
                                   static_cast<float>(settings.max_relative_error),
                                   clusters,
                                   profiles.core_radius() * profiles.core_radius(),
                                   dark_level(tree)};
    counts = clusters ? run(tree, cells, profiles, points, criterion, 64, sums)
                      : sum_all_pairs(tree, cells, profiles.sum(), points, criterion, 4 * profiles.core_radius(), sums);
  }
  count(counts, tree, profiles, points.size(), counters);
  std::vector<glm::vec3> exitance(points.size());
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const int s = tree.masses == 1 ? profiles.sum().table_of[c] : c;
      exitance[i][c] = sums[i][static_cast<std::size_t>(s)] * static_cast<float>(light_colour[c]);
    }
  return exitance;
}

}  // namespace opaline
