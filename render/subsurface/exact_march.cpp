#include "render/subsurface/exact_march.h"

#include "model/fresnel.h"
#include "render/scene/texture_coordinates.h"

#include <limits>

namespace opaline {
namespace {

/// Optical depth beyond which nothing is left.
constexpr double opaque = 16;
constexpr int coarsest = 16;  ///< steps of the first estimate
constexpr double gauss_nodes[2] = {0.21132486540518712, 0.78867513459481288};

double smallest(const glm::dvec3& v) { return std::min({v.x, v.y, v.z}); }
double largest(const glm::dvec3& v) { return std::max({v.x, v.y, v.z}); }

const Object& object_of(const Scene& scene, int object) { return scene.objects[static_cast<std::size_t>(object)]; }

}  // namespace

/// The way of the view ray inside.
struct ExactMarch::View {
  glm::dvec3 origin, direction;  ///< unit, inwards
  LayerPlace start;
  double length;  ///< to where it leaves, or is opaque
  double factor;  ///< of the radiance inside
};

/// A straight way through the layers: places and optical depths at the ends of its steps.
struct ExactMarch::Way {
  double step = 0;
  std::vector<LayerPlace> places;
  std::vector<glm::dvec3> tau;
};

ExactMarch::ExactMarch(const Scene& scene, const RayScene& rays, int object, const ExactSettings& settings)
    : mesh_(object_of(scene, object).mesh),
      settings_(settings),
      eta_(settings.refraction ? scene.materials[static_cast<std::size_t>(object_of(scene, object).material)].eta
                               : 1.0),
      textures_(*scene.materials[static_cast<std::size_t>(object_of(scene, object).material)].layers),
      stack_(textures_),
      surface_(mesh_.positions, mesh_.triangles),
      interior_(scene, rays, object) {}

LayerPlace ExactMarch::place_on_surface(std::uint32_t triangle, const glm::dvec3& point) const {
  float boundaries[LayeredMedium::most_layers];
  textures_.boundaries(uv_at(mesh_, triangle, glm::vec3(point)), boundaries);
  return {0, boundaries, stack_.count};
}

LayerPlace ExactMarch::place_at(const glm::dvec3& point, double& depth, ExactCounts& counts) const {
  ++counts.nearest_points;
  const TrianglePlace nearest = surface_.find_within(glm::vec3(point), depth);
  depth = nearest.distance;
  float boundaries[LayeredMedium::most_layers];
  textures_.boundaries(uv_at(mesh_, nearest.triangle, glm::vec3(nearest.position)), boundaries);
  return {static_cast<float>(nearest.distance), boundaries, stack_.count};
}

/// In steps of about `step`, to the end (whose place may be known) or to where nothing is left.
ExactMarch::Way ExactMarch::way_through(const glm::dvec3& from, const LayerPlace& start, double depth,
                                        const glm::dvec3& direction, double length, double step, const LayerPlace* end,
                                        ExactCounts& counts) const {
  const int steps = std::max(1, static_cast<int>(std::ceil(length / step - 1e-9)));
  Way way{length / steps, {start}, {glm::dvec3(0)}};
  for (int i = 1; i <= steps; ++i) {
    depth += way.step;  // a place is at most a step further from the surface than the one before
    const LayerPlace next = i == steps && end ? *end : place_at(from + (i * way.step) * direction, depth, counts);
    glm::dvec3 tau = way.tau.back();
    for_each_piece(way.places.back(), next, stack_.count, [&](int layer, float t0, float t1) {
      tau += static_cast<double>(t1 - t0) * way.step * glm::dvec3(stack_.sigma_t[static_cast<std::size_t>(layer)]);
    });
    way.places.push_back(next), way.tau.push_back(tau);
    if (smallest(tau) > opaque) {
      counts.steps_negligible += static_cast<std::uint64_t>(steps - i);
      break;
    }
  }
  return way;
}

/// Calls visit(direction to the light inside, length inside, where it enters, its irradiance facing it without
/// extinction) for every free way on which the light comes.
template <typename Visit>
void ExactMarch::for_each_light(const glm::dvec3& m, const MarchLight& light, ExactCounts& counts,
                                Visit&& visit) const {
  const PointOrDirection where{light.far, glm::dvec3(light.place)};
  const glm::dvec3 power(light.power);
  if (eta_ == 1) {
    const glm::dvec3 w = where.towards(m);
    const auto hit = interior_.boundary(m, w, counts.rays);
    if (!hit) {
      ++counts.lost;
      return;
    }
    const glm::dvec3 k = m + hit->distance * w;
    const double to_light = light.far ? std::numeric_limits<double>::infinity() : glm::length(where.place - k);
    if (!interior_.free_outside(k, interior_.facet(hit->facet).normal, w, to_light, counts.rays)) {
      ++counts.shadowed;
      return;
    }
    const double square = light.far ? 1 : glm::dot(where.place - m, where.place - m);
    return visit(w, hit->distance, hit->facet, k, power / square);
  }
  interior_.tree().for_each_ray(
      where, m, eta_, std::numeric_limits<double>::infinity(), counts.search,
      [&](const RefractedRay& ray, const Facet& facet) {
        if (!interior_.free_inside(m, ray.u, ray.length, counts.rays) ||
            !interior_.free_outside(ray.point, facet.normal, ray.l, ray.light_distance, counts.rays)) {
          ++counts.shadowed;
          return;
        }
        const auto index = static_cast<std::uint32_t>(&facet - interior_.tree().facets().data());
        visit(ray.u, ray.length, index, ray.point, power * ray.irradiance);
      });
}

/// Light that arrives at a point from all lights and ways, times the layer's phase function.
glm::dvec3 ExactMarch::arriving(const glm::dvec3& m, int layer, const View& view, const std::vector<MarchLight>& lights,
                                double step, ExactCounts& counts) const {
  glm::dvec3 sum(0);
  double depth = glm::length(m - view.origin);
  const LayerPlace here = place_at(m, depth, counts);
  for (const MarchLight& light : lights)
    for_each_light(m, light, counts,
                   [&](const glm::dvec3& w, double length, std::uint32_t facet, const glm::dvec3& k,
                       const glm::dvec3& irradiance) {
                     ++counts.light_paths;
                     const LayerPlace end = place_on_surface(facet, k);
                     const glm::dvec3 tau = way_through(m, here, depth, w, length, step, &end, counts).tau.back();
                     const float phase = stack_.phase(layer, glm::vec3(w), glm::vec3(-view.direction));
                     sum += static_cast<double>(phase) * irradiance * glm::exp(-tau);
                   });
  return sum;
}

/// The sum over the steps' pieces of one layer each, by the Gauss-Legendre rule of two nodes.
glm::dvec3 ExactMarch::scattered(const View& view, const std::vector<MarchLight>& lights, int steps,
                                 ExactCounts& counts) const {
  const double step = view.length / steps;
  const Way way = way_through(view.origin, view.start, 0, view.direction, view.length, step, nullptr, counts);
  glm::dvec3 sum(0);
  for (std::size_t i = 0; i + 1 < way.places.size(); ++i) {
    glm::dvec3 tau = way.tau[i];
    for_each_piece(way.places[i], way.places[i + 1], stack_.count, [&](int layer, float t0, float t1) {
      const auto k = static_cast<std::size_t>(layer);
      const double part = static_cast<double>(t1 - t0) * way.step;
      const glm::dvec3 fade = part * glm::dvec3(stack_.sigma_t[k]), sigma_s(stack_.sigma_s[k]);
      // Steps that cross a boundary keep their pieces when steps are halved: so these are halved themselves.
      const int parts = t0 == 0 && t1 == 1 ? 1 : std::max(1, steps / coarsest);
      for (int j = 0; j < parts && sigma_s != glm::dvec3(0); ++j)
        for (const double node : gauss_nodes) {
          const double share = (j + node) / parts;
          const double at =
              (static_cast<double>(i) + static_cast<double>(t0) + share * static_cast<double>(t1 - t0)) * way.step;
          sum += 0.5 * part / parts * sigma_s * glm::exp(-tau - share * fade) *
                 arriving(view.origin + at * view.direction, layer, view, lights, step, counts);
        }
      tau += fade;
    });
  }
  return view.factor * sum;
}

ExactMarch::Estimate ExactMarch::radiance(const VisiblePoint& p, const std::vector<MarchLight>& lights,
                                          ExactCounts& counts) const {
  const glm::dvec3 origin(p.position), w_o = glm::normalize(glm::dvec3(p.w_o));
  const glm::dvec3 normal = interior_.facet(p.triangle).normal;
  const double cosine = glm::dot(normal, w_o);
  const auto inside = cosine > 0 ? direction_inside(w_o, normal, eta_) : std::nullopt;
  if (!inside) return {};
  View view{origin, -*inside, place_on_surface(p.triangle, origin), 0,
            fresnel_transmittance(std::min(cosine, 1.0), eta_) / (eta_ * eta_)};
  const auto exit = interior_.boundary(origin, view.direction, counts.rays);
  if (!exit) {
    ++counts.lost;
    return {};
  }
  view.length = exit->distance;
  // The march needs no further than a coarse one sees.
  const Way coarse = way_through(origin, view.start, 0, view.direction, view.length, view.length / 64, nullptr, counts);
  view.length = coarse.step * static_cast<double>(coarse.tau.size() - 1);
  if (!(view.length > 0)) return {};
  Estimate best;
  glm::dvec3 before = scattered(view, lights, coarsest, counts);
  for (int steps = 2 * coarsest; steps <= settings_.most_steps; steps *= 2) {
    ++counts.estimates;
    best.radiance = scattered(view, lights, steps, counts);
    best.error = glm::abs(best.radiance - before);
    if (largest(best.error) <= settings_.max_relative_error * largest(best.radiance)) return best;
    before = best.radiance;
  }
  ++counts.unconverged;
  return best;
}

}  // namespace opaline
