// Light through flat facets of a dielectric: refraction, mirror images, and the one refracted ray that joins a point
// inside with a light outside through the plane of a facet.
//
// Lengths in mm, eta = n_inside / n_outside, normals unit and outward, directions unit. `l` points from the facet to
// the light (outside), `u` from a point inside to the facet: u and l are one straight line at eta = 1.
//
// Why geometric normals: the surface that is traced is the polyhedron itself, so energy and reciprocity hold exactly.
#pragma once

#include "model/conventions.h"

#include <glm/glm.hpp>

#include <optional>

namespace opaline {

struct Facet {
  glm::dvec3 corner, edge_1, edge_2, normal;

  double area() const { return glm::length(glm::cross(edge_1, edge_2)) / 2; }
  glm::dvec3 at(double u, double v) const { return corner + u * edge_1 + v * edge_2; }
  /// Is the point (of the facet's plane) in the triangle? On an edge it is in one of the two that share it.
  bool contains(const glm::dvec3& point) const;
};

/// u of the ray that leaves along l (cosine > 0 with the normal); none under total reflection (eta < 1).
std::optional<glm::dvec3> direction_inside(const glm::dvec3& l, const glm::dvec3& normal, double eta);

/// l of the ray that arrives along u; none under total internal reflection.
std::optional<glm::dvec3> direction_outside(const glm::dvec3& u, const glm::dvec3& normal, double eta);

inline glm::dvec3 mirrored(const glm::dvec3& direction, const glm::dvec3& normal) {
  return direction - 2 * glm::dot(direction, normal) * normal;
}
inline glm::dvec3 mirror_image(const glm::dvec3& point, const Facet& facet) {
  return point - 2 * glm::dot(point - facet.corner, facet.normal) * facet.normal;
}

/// A light that reaches every point from one direction: far away, or at a point.
struct PointOrDirection {
  bool far = true;
  glm::dvec3 place{0};  ///< far: unit, towards the light; else its position
  /// A projector lights only what is within `half_angle` (< pi/2) of `axis`; pi: everything.
  glm::dvec3 axis{0};
  double half_angle = pi;

  glm::dvec3 towards(const glm::dvec3& point) const { return far ? place : glm::normalize(place - point); }
  /// Might a part of that ball be lit?
  bool may_light(const glm::dvec3& centre, double radius) const;
};

/// The refracted ray from a point inside to a light.
struct RefractedRay {
  glm::dvec3 u, point, l;  ///< direction at the point inside, where the facet is crossed, direction to the light
  double length = 0;       ///< inside [mm]
  double light_distance = 0;
  /// Irradiance at the point inside on a plane facing the ray, without extinction: of a far light per unit of its
  /// irradiance outside, of a near one per unit of intensity. Fresnel transmission and the change of the beam's
  /// width are in it.
  double irradiance = 0;
};

/// The ray from y (inside, behind the facet) through this facet, if there is one. What stands in the way is the
/// caller's business. One point exists at most: for a far light the direction is fixed, for a near one Snell's law
/// along the plane is monotone.
std::optional<RefractedRay> refracted_ray(const Facet& facet, const PointOrDirection& light, const glm::dvec3& y,
                                          double eta);

}  // namespace opaline
