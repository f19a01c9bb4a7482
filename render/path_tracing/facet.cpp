#include "render/path_tracing/facet.h"

#include "model/fresnel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace opaline {

namespace {

bool comes_before(const glm::dvec3& a, const glm::dvec3& b) {
  return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
}

/// Is p left of the edge a -> b? Always computed from the same end, so that an edge parts its two facets without gap
/// and without overlap: symmetric scenes do hit edges.
bool left_of(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& normal) {
  if (comes_before(a, b)) return glm::dot(glm::cross(b - a, p - a), normal) >= 0;
  return glm::dot(glm::cross(a - b, p - b), normal) < 0;
}

}  // namespace

bool Facet::contains(const glm::dvec3& point) const {
  const glm::dvec3 b = corner + edge_1, c = corner + edge_2;
  return left_of(point, corner, b, normal) && left_of(point, b, c, normal) && left_of(point, c, corner, normal);
}

std::optional<glm::dvec3> direction_inside(const glm::dvec3& l, const glm::dvec3& normal, double eta) {
  const double cosine = glm::dot(l, normal), square = 1 - (1 - cosine) * (1 + cosine) / (eta * eta);
  if (square <= 0) return std::nullopt;
  return glm::normalize(l / eta + (std::sqrt(square) - cosine / eta) * normal);
}

std::optional<glm::dvec3> direction_outside(const glm::dvec3& u, const glm::dvec3& normal, double eta) {
  return direction_inside(u, normal, 1 / eta);
}

bool PointOrDirection::may_light(const glm::dvec3& centre, double radius) const {
  if (far || half_angle >= pi) return true;
  const glm::dvec3 d = centre - place;
  const double distance = glm::length(d);
  if (distance <= radius) return true;
  return std::acos(std::clamp(glm::dot(d, axis) / distance, -1.0, 1.0)) <= half_angle + std::asin(radius / distance);
}

namespace {

std::optional<RefractedRay> ray_to_far_light(const Facet& facet, const glm::dvec3& l, const glm::dvec3& y, double depth,
                                             double eta) {
  const double cosine = glm::dot(l, facet.normal);
  if (cosine <= 0) return std::nullopt;
  const auto u = direction_inside(l, facet.normal, eta);
  if (!u) return std::nullopt;
  RefractedRay ray;
  const double cos_inside = glm::dot(*u, facet.normal);
  ray.u = *u;
  ray.length = depth / cos_inside;
  ray.point = y + ray.length * ray.u;
  if (!facet.contains(ray.point)) return std::nullopt;
  ray.l = l;
  ray.light_distance = std::numeric_limits<double>::infinity();
  ray.irradiance = fresnel_transmittance(cosine, eta) * cosine / cos_inside;
  return ray;
}

/// Distance x along the plane from the foot of the point inside to where the ray crosses: the root of
/// eta sin(inside) - sin(outside), which rises with x from below 0 at x = 0 to above 0 at x = across.
double crossing(double depth, double height, double across, double eta) {
  double lo = 0, hi = across, x = across * depth / (depth + height);
  for (int i = 0; i < 100 && hi - lo > 1e-15 * across; ++i) {
    const double a = std::hypot(x, depth), b = std::hypot(across - x, height);
    const double f = eta * x / a - (across - x) / b;
    (f > 0 ? hi : lo) = x;
    const double slope = eta * depth * depth / (a * a * a) + height * height / (b * b * b);
    const double newton = x - f / slope;
    const double next = newton > lo && newton < hi ? newton : (lo + hi) / 2;
    if (std::abs(next - x) <= 1e-15 * across) return next;
    x = next;
  }
  return x;
}

std::optional<RefractedRay> ray_to_near_light(const Facet& facet, const glm::dvec3& light, const glm::dvec3& y,
                                              double depth, double eta) {
  const double height = glm::dot(light - facet.corner, facet.normal);
  if (height <= 0) return std::nullopt;
  const glm::dvec3 foot = y + depth * facet.normal, along = light - height * facet.normal - foot;
  const double across = glm::length(along);
  RefractedRay ray;
  ray.point = across > 0 ? foot + crossing(depth, height, across, eta) / across * along : foot;
  if (!facet.contains(ray.point)) return std::nullopt;
  ray.length = glm::length(ray.point - y);
  ray.light_distance = glm::length(light - ray.point);
  ray.u = (ray.point - y) / ray.length;
  ray.l = (light - ray.point) / ray.light_distance;
  // A pencil of solid angle sin(o) do dphi crosses the plane facing it at y in (D dphi) (cos_i dD), where D = across is
  // h tan(o) + d tan(i) and cos(o) do = eta cos(i) di.
  const double o = height / ray.light_distance, i = depth / ray.length;
  const double sagittal = height / o + depth / (eta * i);
  const double meridional = height / (o * o) + depth * o / (eta * i * i * i);
  ray.irradiance = fresnel_transmittance(std::min(o, 1.0), eta) / (i * sagittal * meridional);
  return ray;
}

}  // namespace

std::optional<RefractedRay> refracted_ray(const Facet& facet, const PointOrDirection& light, const glm::dvec3& y,
                                          double eta) {
  const double depth = glm::dot(facet.corner - y, facet.normal);
  if (depth <= 0) return std::nullopt;
  return light.far ? ray_to_far_light(facet, light.place, y, depth, eta)
                   : ray_to_near_light(facet, light.place, y, depth, eta);
}

}  // namespace opaline
