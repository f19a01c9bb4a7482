#include "render/path_tracing/light_chain.h"

#include "model/fresnel.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

/// An estimate of the light on a facet, positive wherever there may be some.
double light_on(const Facet& facet, const PointOrDirection& where, double spread) {
  const glm::dvec3 centre = facet.at(1.0 / 3, 1.0 / 3);
  const double angle = std::acos(std::clamp(glm::dot(where.towards(centre), facet.normal), -1.0, 1.0));
  const double cosine = std::cos(std::max(0.0, angle - spread));
  if (cosine <= 0) return 0;
  if (where.far) return facet.area() * cosine;
  const double radius = std::max(
      {glm::length(facet.corner - centre), glm::length(facet.at(1, 0) - centre), glm::length(facet.at(0, 1) - centre)});
  if (!where.may_light(centre, radius)) return 0;
  const glm::dvec3 d = where.place - centre;
  return facet.area() * cosine / std::max(glm::dot(d, d), radius * radius);
}

glm::dvec3 uniform_point(const Facet& facet, RandomStream& random) {
  const double root = std::sqrt(random()), v = random();
  return facet.at(1 - root, root * v);
}

/// The way light from the lamp takes from a point of the facet into the medium.
std::optional<glm::dvec3> entering(const Facet& facet, const glm::dvec3& point, const PointOrDirection& where,
                                   double eta) {
  const glm::dvec3 l = where.towards(point);
  if (glm::dot(l, facet.normal) <= 0) return std::nullopt;
  const auto u = direction_inside(l, facet.normal, eta);
  if (!u) return std::nullopt;
  return -*u;
}

}  // namespace

LightChains::LightChains(const Interior& interior, const PathLights& lights, std::size_t light, double extinction)
    : interior_(&interior),
      going_on_(std::clamp(std::exp(-extinction * interior.mean_chord()), 0.2, 0.95)),
      scale_(2 / extinction) {
  if (interior.eta() == 1) return;  // nothing reflects
  const auto [where, spread] = lights.reach(light);
  for (const Facet& facet : interior.tree().facets()) light_.push_back(light_on(facet, where, spread));
  sums_ = interior.tree().node_sums(light_);
  if (!(sums_.front() > 0)) light_.clear();
}

LightChain LightChains::draw(const Lamp& lamp, const glm::dvec3& near, RandomStream& random, RayCounts& rays,
                             ChainCounts& counts) const {
  LightChain chain;
  if (light_.empty()) return chain;
  const FacetTree::Drawn drawn = interior_->tree().draw(light_, sums_, near, scale_, random());
  chain.entry = drawn.facet;
  chain.entry_probability = drawn.probability;
  const Facet& entry = interior_->facet(chain.entry);
  glm::dvec3 point = uniform_point(entry, random);
  auto direction = entering(entry, point, lamp.where, interior_->eta());
  // How likely a chain goes on must depend on its facets alone, so a ray through the facet's centre decides.
  auto guide = entering(entry, entry.at(1.0 / 3, 1.0 / 3), lamp.where, interior_->eta());
  if (!direction) return chain;
  ++counts.chains;
  for (double survival = 1;;) {
    const auto hit = interior_->boundary(point, *direction, rays);
    if (!hit) return chain;
    ++counts.links;
    chain.mirrors.push_back(hit->facet);
    chain.survival.push_back(survival);
    const glm::dvec3& normal = interior_->facet(hit->facet).normal;
    const double cosine = guide ? std::min(1.0, std::abs(glm::dot(*guide, normal))) : 0;
    const double on = going_on_ * (guide ? fresnel_reflectance(cosine, 1 / interior_->eta()) : 1);
    if (!(random() < on)) return chain;
    survival *= on;
    point += hit->distance * *direction;
    direction = mirrored(*direction, normal);
    if (guide) guide = mirrored(*guide, normal);
  }
}

bool LightChains::straighten(const LightChain& chain, std::size_t mirrors, const Lamp& lamp, const glm::dvec3& y,
                             ChainLight& light, std::vector<glm::dvec3>& corners) const {
  glm::dvec3 image = y;
  for (std::size_t k = mirrors; k-- > 0;) image = mirror_image(image, interior_->facet(chain.mirrors[k]));
  const auto ray = refracted_ray(interior_->facet(chain.entry), lamp.where, image, interior_->eta());
  if (!ray) return false;
  glm::dvec3 point = ray->point, direction = -ray->u;
  double rest = ray->length;
  corners.assign(1, point);
  light.reflectance = 1;
  for (std::size_t k = 0; k < mirrors; ++k) {
    const Facet& mirror = interior_->facet(chain.mirrors[k]);
    const double cosine = glm::dot(direction, mirror.normal);
    if (cosine <= 0) return false;
    const double length = glm::dot(mirror.corner - point, mirror.normal) / cosine;
    point += length * direction;
    if (length <= 0 || !mirror.contains(point)) return false;
    corners.push_back(point);
    light.reflectance *= fresnel_reflectance(std::min(cosine, 1.0), 1 / interior_->eta());
    direction = mirrored(direction, mirror.normal);
    rest -= length;
  }
  corners.push_back(y);
  light.ray = *ray;
  light.u = -direction;
  light.mirrors = mirrors;
  return rest > 0;
}

bool LightChains::is_free(const LightChain& chain, const ChainLight& light, const std::vector<glm::dvec3>& corners,
                          RayCounts& rays) const {
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    const glm::dvec3 d = corners[k + 1] - corners[k];
    const double length = glm::length(d);
    if (length == 0) return false;
    const auto hit = interior_->boundary(corners[k], d / length, rays);
    if (!hit) return false;
    const bool reaches = k < light.mirrors ? hit->facet == chain.mirrors[k] : hit->distance >= length;
    if (!reaches) return false;
  }
  return interior_->free_outside(corners[0], interior_->facet(chain.entry).normal, light.ray.l,
                                 light.ray.light_distance, rays);
}

double LightChains::draws_until_met(const LightChain& chain, std::size_t mirrors, const Lamp& lamp,
                                    RandomStream& random, RayCounts& rays, ChainCounts& counts) const {
  constexpr std::uint64_t limit = 1'000'000;  // a chain met so rarely is one that rounding made
  for (std::uint64_t draws = 1; draws < limit; ++draws) {
    ++counts.trials;
    if (meets(chain, mirrors, lamp, random, rays)) return static_cast<double>(draws);
  }
  ++counts.trials_given_up;
  return static_cast<double>(limit);
}

bool LightChains::meets(const LightChain& chain, std::size_t mirrors, const Lamp& lamp, RandomStream& random,
                        RayCounts& rays) const {
  const Facet& entry = interior_->facet(chain.entry);
  glm::dvec3 point = uniform_point(entry, random);
  auto direction = entering(entry, point, lamp.where, interior_->eta());
  if (!direction) return false;
  for (std::size_t k = 0; k < mirrors; ++k) {
    const auto hit = interior_->boundary(point, *direction, rays);
    if (!hit || hit->facet != chain.mirrors[k]) return false;
    point += hit->distance * *direction;
    direction = mirrored(*direction, interior_->facet(hit->facet).normal);
  }
  return true;
}

}  // namespace opaline
