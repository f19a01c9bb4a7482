// The criterion of the reference: a cluster is used whole where a rigorous bound on the error of doing so is a small
// part of what it gives, or of its share, by flux, of the whole. The shares add up to one, so the bounds of a query
// add up to less than the tolerance. Derivation: irradiance.md.
#pragma once

#include "render/irradiance/cluster_tree.h"
#include "render/irradiance/profile_bounds.h"

#include <cmath>

namespace opaline {

/// How many times larger than the error of a picture the bound is, about. Bounds add up without cancelling and take
/// every derivative at its largest, so they are far above the errors, the more so the larger the clusters are.
/// Calibrated so that the RMS over a picture is at most half the tolerance (tests/render).
inline float pessimism_of_bounds(double tolerance) {
  return std::max(1.0f, 1500 * static_cast<float>(std::pow(100 * tolerance, 0.4)));
}

class CertifiedCriterion {
 public:
  static constexpr float moments = 1;
  using Four = ProfileBounds::Four;

  /// tolerance: relative to the exitance, or to `dark` (per output) where that is larger
  /// pessimism: how many times larger than the error the bound by expansion may be taken to be; 1: it is the bound
  /// itself that keeps the tolerance
  CertifiedCriterion(const ClusterTree& tree, const ProfileBounds& bounds, const ProfileSum& profile, float tolerance,
                     const Four& dark, float pessimism)
      : tree_(tree),
        bounds_(bounds),
        profile_(profile),
        tolerance_(tolerance),
        dark_(dark),
        optimism_(1 / pessimism),
        core_(std::sqrt(bounds.core_squared())) {}

  void begin_group(const glm::vec3& centre, float) {
    own_ = tolerance_ * (1 - shared_part);
    estimate_shares(centre);
  }

  void tighten(float factor) {
    own_ *= factor;
    for (float& share : share_) share *= factor;
  }

  bool accept(const ClusterNode& node, float distance, float group_radius) {
    return accept(node.extent, distance, group_radius);
  }
  bool accept_part(const ClusterNode& leaf, float scale, float distance, float group_radius) {
    return accept(leaf.extent.scaled(scale), distance, group_radius);
  }

  /// May a patch of that extent be used whole by every query within group_radius of a point at `distance`?
  bool accept(const ClusterExtent& e, float distance, float group_radius) {
    const float nearest = std::max(distance - group_radius, 0.0f), farthest = distance + group_radius;
    // The expansion is worth nothing as an estimate where the patch looks large.
    const bool small = e.radius * e.radius <= max_opening * (nearest * nearest + bounds_.core_squared());
    // Around a query such a patch takes the profile from its top: not worth the arithmetic below.
    if (!small && nearest <= e.radius) return false;
    const float gap = std::max(nearest - e.radius, 0.0f), reach = farthest + e.radius;
    const ProfileBounds::Row& row = bounds_.from(gap * gap);
    const Four& low = bounds_.up_to(reach * reach).low;
    const Four& gives = bounds_.up_to((distance + e.radius) * (distance + e.radius)).low;
    noise_ = &row.noise;
    // The largest D / x over the distances D of the group, x = gap^2 + core^2: it rises up to this D and falls beyond.
    const float steepest = nearest >= e.radius + core_
                               ? nearest
                               : std::clamp(std::sqrt(e.radius * e.radius + core_ * core_), nearest, farthest);
    const float gap_there = std::max(steepest - e.radius, 0.0f);
    const float per_x = 1 / (gap * gap + core_ * core_), m = steepest / (gap_there * gap_there + core_ * core_);
    const float y = 2 * m * e.fourth + e.bulge * per_x, y4 = y * y * y * y;
    const float off = std::max(e.radius * e.radius - e.trace, e.trace);
    const float deviation = e.deviation * per_x;
    const float z = 12 * m * m * e.mixed * per_x + deviation * deviation * (6 * m * e.radius + off * per_x);
    // Below the axis there is no profile: the nearer point is moved to it.
    float first = gap > 0 ? 0 : 0.5f * std::max(e.deviation - e.trace, 0.0f) * per_x, second = 0;
    if (e.unlike > 0) {
      const float sigma = 2 * m * std::sqrt(e.stretch) + deviation;
      first += e.unlike * deviation;
      second = 1.1f * e.unlike * sigma * sigma;
    }
    const float optimism = small ? optimism_ : 1;
    int rejected = 0;  // plain loops over four floats: compilers make vectors of them
    for (std::size_t o = 0; o < 4; ++o) {
      const float expansion =
          rounding * (row.fourth[o] * y4 + row.third[o] * z + row.second[o] * second + row.first[o] * first);
      const float range = row.high[o] - low[o];
      error_[o] = expansion < range ? expansion : range;
      const float likely = optimism * expansion < range ? optimism * expansion : range;
      rejected += likely > share_[o] + own_ * gives[o];
    }
    return rejected == 0;
  }

  void use(const float* mass, float fraction) {
    const int step = tree_.masses == 1 ? 0 : 1;
    for (int o = 0; o < bounds_.outputs(); ++o) {
      const auto i = static_cast<std::size_t>(o);
      kept_[i] += fraction * mass[o * step] * (error_[i] + (*noise_)[i]);
    }
  }

  std::array<float, 3> take_bound() {
    const std::array<float, 3> bound{kept_[0], kept_[1], kept_[2]};
    kept_ = {};
    return bound;
  }

 private:
  /// Of the tolerance, what is shared out by flux; the rest is in proportion to what a cluster gives.
  static constexpr float shared_part = 0.2f;

  static constexpr float max_opening = 0.8f;  ///< (radius / distance)^2
  static constexpr float rounding = 1.001f;

  /// The tolerated error of each output per unit of flux, from a coarse look at the whole surface: clusters as points,
  /// opened while they look large.
  void estimate_shares(const glm::vec3& p) {
    Four sum{};
    for (std::size_t i = 0; i < tree_.nodes.size();) {
      const ClusterNode& node = tree_.nodes[i];
      const glm::vec3 d = node.centroid - p;
      const float r2 = glm::dot(d, d) + node.extent.trace;
      const bool use = node.leaf() || 2 * node.extent.radius * node.extent.radius < r2;
      if (use) add_point(&tree_.mass[i * static_cast<std::size_t>(tree_.masses)], r2, sum);
      i = use ? node.skip : i + 1;
    }
    for (std::size_t o = 0; o < 4; ++o) {
      const double flux = o < 3 ? tree_.total_mass[tree_.masses == 1 ? 0 : o] : 0;
      const float exitance = std::max(dark_[o], cautious * sum[o]);
      share_[o] = flux > 0 ? tolerance_ * shared_part * exitance / static_cast<float>(flux) : 1e30f;
    }
  }
  /// The estimate is at a group's centre, and of clusters as points.
  static constexpr float cautious = 0.7f;

  void add_point(const float* mass, float r2, Four& sum) const {
    for (int o = 0; o < bounds_.outputs(); ++o) {
      const int table = tree_.masses == 1 ? o : profile_.table_of[o];
      sum[static_cast<std::size_t>(o)] += mass[tree_.masses == 1 ? 0 : o] * (*profile_.tables[table])(r2);
    }
  }

  const ClusterTree& tree_;
  const ProfileBounds& bounds_;
  const ProfileSum& profile_;
  float tolerance_;
  Four dark_;
  float optimism_;
  float core_, own_ = 0;
  Four share_{}, error_{}, kept_{};
  const Four* noise_ = nullptr;
};

}  // namespace opaline
