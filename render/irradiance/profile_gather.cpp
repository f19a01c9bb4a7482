#include "render/irradiance/profile_gather.h"

#include "model/check.h"
#include "render/irradiance/all_pairs.h"
#include "render/irradiance/certified_criterion.h"

#include <cmath>

namespace opaline {
namespace {

/// What the sums lose by being taken in float: fluxes, weights and additions, relative to the sum.
constexpr float sum_error = 3e-6f;

struct Exitance {
  std::vector<std::array<float, 3>> sums, bounds;
};

/// Adds up one group's patches and their bounds.
struct ExitanceSink {
  using Patches = PatchList;
  const ProfileSum& profile;
  Exitance& out;
  float tolerance;            ///< 0: no group is ever repeated
  std::array<float, 3> dark;  ///< exitance from which the tolerance is counted
  std::span<const std::uint32_t> queries;
  std::span<const glm::vec3> positions;
  std::vector<std::array<float, 3>> sums{}, bounds{};

  void begin_group(std::span<const std::uint32_t> group, std::span<const glm::vec3> at) {
    queries = group, positions = at;
    sums.assign(group.size(), {});
    bounds.assign(group.size(), {});
  }
  void add(const PatchList& patches, std::size_t first, std::size_t count, const std::array<float, 3>& bound) {
    add_profile_sums(profile, patches, nullptr, positions.subspan(first, count), &sums[first]);
    for (std::size_t i = first; i < first + count; ++i)
      for (std::size_t o = 0; o < 3; ++o) bounds[i][o] += bound[o];
  }
  float end_group() {
    float excess = 0;
    for (std::size_t i = 0; i < queries.size(); ++i) {
      for (std::size_t o = 0; o < 3; ++o) {
        bounds[i][o] += sum_error * sums[i][o];
        const float allowed = tolerance * std::max(sums[i][o], dark[o]);
        if (bounds[i][o] > excess * allowed) excess = bounds[i][o] / std::max(allowed, 1e-30f);
      }
      out.sums[queries[i]] = sums[i];
      out.bounds[queries[i]] = bounds[i];
    }
    return tolerance > 0 ? excess : 0;
  }
};

/// The published test: the node looks small and the point is outside it. Leaves are points.
struct SolidAngleCriterion {
  static constexpr float moments = 0;
  float quality;
  void begin_group(const glm::vec3&, float) {}
  bool accept(const ClusterNode& node, float distance, float) const {
    return node.leaf() || (distance > node.extent.radius && node.area < quality * distance * distance);
  }
  bool accept_part(const ClusterNode&, float, float, float) const { return true; }
  void use(const float*, float) {}
  std::array<float, 3> take_bound() { return {}; }
  void tighten(float) {}
};

void count(const GatherCounts& c, const ClusterTree& tree, const ChannelProfiles& profiles, std::size_t points,
           Counters& counters) {
  counters.done["queries"] += points;
  counters.done["groups"] += c.groups;
  counters.done["groups_repeated"] += c.groups_repeated;
  counters.done["nodes_visited"] += c.nodes_visited;
  counters.done["clusters"] += c.clusters;
  counters.done["cells"] += c.cells;
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

ChannelProfiles::ChannelProfiles(const ProfileInfo& info, const Material& material, double r_max,
                                 double largest_coordinate) {
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
  sum_.table_count = static_cast<int>(owner.size());
  tables_.reserve(owner.size());
  std::vector<const Profile*> distinct;
  for (const int c : owner) {
    const Profile& p = profile(c);
    distinct.push_back(&p);
    tables_.emplace_back([&p](double r) { return p.evaluate(r); }, core, r_max);  // one core: same segments
    sum_.tables[tables_.size() - 1] = &tables_.back();
  }
  // Two half units in the last place of each of three coordinates.
  const double position_error =
      2 * std::sqrt(3.0) * 0x1p-24 * (largest_coordinate > 0 ? largest_coordinate : r_max / 2);
  bounds_ = ProfileBounds(distinct, sum_, core, r_max, position_error);
  channel_bounds_ = bounds_.per_channel(sum_.table_of);
}

namespace {

/// A thousandth of the mean irradiance of the lit cells, per channel: below that a point counts as dark.
std::array<float, 3> dark_level(const ClusterTree& tree) {
  std::array<float, 3> dark{};
  for (std::size_t o = 0; o < 3; ++o)
    dark[o] = static_cast<float>(1e-3 * tree.total_mass[tree.masses == 1 ? 0 : o]) / tree.nodes.front().area;
  return dark;
}

using Criterion = GatherSettings::Criterion;

bool bounded(const GatherSettings& settings) {
  return settings.criterion == Criterion::bound || settings.criterion == Criterion::error;
}

/// How many times larger than the error the bound is taken to be; single cells are no clusters.
float pessimism(const GatherSettings& settings) {
  if (settings.criterion == Criterion::error) return pessimism_of_bounds(settings.max_relative_error);
  return settings.criterion == Criterion::none ? 20 : 1;
}

Exitance gather_sums(const ClusterTree& tree, const SurfaceCells& cells, const ChannelProfiles& profiles,
                     std::span<const glm::vec3> points, const GatherSettings& settings, GatherCounts& counts) {
  Exitance out;
  out.sums.assign(points.size(), {0, 0, 0});
  out.bounds.assign(points.size(), {0, 0, 0});
  if (tree.nodes.empty()) return out;
  const auto tolerance = static_cast<float>(settings.max_relative_error);
  const std::array<float, 3> dark = dark_level(tree);
  const float too_large = pessimism(settings);
  const CertifiedCriterion certified(tree, profiles.bounds(tree.masses), profiles.sum(), tolerance,
                                     {dark[0], dark[1], dark[2], 0}, too_large);
  // An estimated group is repeated when its bounds are unusual: some of its points are much darker than its middle.
  const float allowed = settings.criterion == Criterion::bound   ? tolerance
                        : settings.criterion == Criterion::error ? 0.25f * too_large * tolerance
                                                                 : 0;
  const auto sink = [&] { return ExitanceSink{profiles.sum(), out, allowed, dark, {}, {}}; };
  if (settings.criterion == Criterion::none) {
    counts = sum_all_pairs(tree, cells, profiles.sum(), points, certified,
                           4 * std::sqrt(profiles.bounds(tree.masses).core_squared()), out.sums);
  } else if (settings.criterion == Criterion::solid_angle) {
    const SolidAngleCriterion criterion{static_cast<float>(settings.quality)};
    counts = gather(
        tree, cells, points, [&] { return criterion; }, sink, 1);
  } else {
    counts = gather(
        tree, cells, points, [&] { return certified; }, sink);
  }
  return out;
}

/// Points where some channel's bound is larger than was asked.
std::uint64_t over_tolerance(const Exitance& e, const ClusterTree& tree, double tolerance) {
  if (tree.nodes.empty()) return 0;
  const std::array<float, 3> dark = dark_level(tree);
  std::uint64_t over = 0;
  for (std::size_t i = 0; i < e.sums.size(); ++i) {
    bool within = true;
    for (std::size_t o = 0; o < 3; ++o)
      within &= e.bounds[i][o] <= static_cast<float>(tolerance) * std::max(e.sums[i][o], dark[o]);
    over += !within;
  }
  return over;
}

}  // namespace

std::vector<glm::vec3> gather_exitance(const ClusterTree& tree, const SurfaceCells& cells,
                                       const ChannelProfiles& profiles, const Rgb& light_colour,
                                       std::span<const glm::vec3> points, const GatherSettings& settings,
                                       Counters& counters, std::vector<glm::vec3>* bound) {
  OPALINE_CHECK(tree.masses == 1 || tree.masses == 3);
  GatherCounts counts;
  const Exitance e = gather_sums(tree, cells, profiles, points, settings, counts);
  count(counts, tree, profiles, points.size(), counters);
  if (settings.criterion == Criterion::bound)
    counters.done["queries_over_tolerance"] += over_tolerance(e, tree, settings.max_relative_error);
  std::vector<glm::vec3> exitance(points.size());
  const bool with_bound = bound && bounded(settings);
  if (bound) bound->assign(with_bound ? points.size() : 0, glm::vec3(0));
  for (std::size_t i = 0; i < points.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const auto o = static_cast<std::size_t>(tree.masses == 1 ? profiles.sum().table_of[c] : c);
      exitance[i][c] = e.sums[i][o] * static_cast<float>(light_colour[c]);
      if (with_bound) (*bound)[i][c] = e.bounds[i][o] * static_cast<float>(light_colour[c]);
    }
  return exitance;
}

}  // namespace opaline
