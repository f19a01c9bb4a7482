#include "fit/straight_view.h"

#include "model/conventions.h"
#include "render/visibility/gbuffer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace opaline {
namespace {

/// Angles from one normal of a plane that all points so far lie in.
class PlaneAngles {
 public:
  explicit PlaneAngles(const VisiblePoint& first) : origin_(first.position), normal_(first.normal) {}

  void add_point(const VisiblePoint& p) {
    const glm::dvec3 from = glm::dvec3(p.position) - origin_;
    size_ = std::max(size_, glm::length(from));
    out_of_plane_ = std::max(out_of_plane_, std::abs(glm::dot(from, normal_)));
    add(p.normal);
    add(p.w_o);
  }
  void add(const glm::dvec3& direction, double radius_deg = 0) {
    const double cosine = std::clamp(glm::dot(glm::normalize(direction), normal_), -1.0, 1.0);
    worst_ = std::max(worst_, std::acos(cosine) * 180 / pi + radius_deg);
  }
  /// Only what falls on the side that is seen counts.
  void add_light(const glm::dvec3& towards, double radius_deg = 0) {
    if (glm::dot(towards, normal_) > 0) add(towards, radius_deg);
  }
  double worst() const { return out_of_plane_ > 1e-3 * size_ ? 180 : worst_; }

 private:
  glm::dvec3 origin_, normal_;
  double size_ = 0, out_of_plane_ = 0, worst_ = 0;
};

/// Visits the directions towards a light from a point; false for an environment.
struct AddLight {
  PlaneAngles& angles;
  glm::dvec3 position;

  bool operator()(const DirectionalLight& l) const {
    return angles.add_light(-l.direction, l.angular_radius_deg), true;
  }
  bool operator()(const PointLight& l) const { return angles.add_light(l.position - position), true; }
  bool operator()(const ProjectorLight& l) const {
    const glm::dvec3 from = position - l.position, axis = l.look_at - l.position;
    const double cosine = glm::dot(glm::normalize(from), glm::normalize(axis));
    const bool outside = !l.image && cosine < std::cos(l.disk_radius_deg * pi / 180);
    if (!outside) angles.add_light(-from);
    return true;
  }
  bool operator()(const EnvironmentLight&) const { return false; }
};

double information(const Solution& s) { return s.minus_two_ln_likelihood; }

std::string compared(double against) {
  return against > 0 ? fmt::format("{:.0f} worse than its exitance, which is too little to go by", against)
                     : fmt::format("{:.0f} better than its exitance", -against);
}

}  // namespace

double off_straight_deg(const Scene& scene, int material) {
  const RayScene rays(scene);
  const GBuffer view = make_gbuffer(scene, rays);
  std::optional<PlaneAngles> angles;
  for (const VisiblePoint& p : view.points) {
    if (scene.objects[static_cast<std::size_t>(p.object)].material != material) continue;
    if (!angles) angles.emplace(p);
    angles->add_point(p);
    for (const Light& light : scene.lights)
      if (!std::visit(AddLight{*angles, p.position}, light)) return 180;
  }
  return angles ? angles->worst() : 180;
}

TransportForm preferred_form(const std::vector<FitTarget>& targets, const Material& initial,
                             const SolveSettings& settings, Solution exitance, double off_deg) {
  const ProfileInfo* radiance_info = find_profile("transport_radiance");
  Solution radiance = solve(targets, *radiance_info, initial, settings);
  const double against = information(radiance) - information(exitance);
  const std::string where = fmt::format("flat, lit and seen within {:.2g} degrees of its normal: ", off_deg);
  if (against > 10)
    return {find_profile("transport_table"), std::move(exitance),
            where + fmt::format("the pictures prefer light that leaves alike in all directions (transport_table), as "
                                "drawings with a profile have it, to transport's own radiance (information criterion "
                                "{:.0f} better). Of a real surface that would be a misfit",
                                against)};
  return {radiance_info, std::move(radiance),
          where + fmt::format("fitted with transport's radiance along the normal (transport_radiance; information "
                              "criterion {}). --exit exitance forbids it",
                              compared(against))};
}

}  // namespace opaline
