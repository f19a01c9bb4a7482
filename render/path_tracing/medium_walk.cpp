#include "render/path_tracing/medium_walk.h"

#include "model/fresnel.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

/// Connections that carry less than this are made with a probability. A larger share of cheap walks pays more than
/// long searches for faint light: 0.3 was about the best of 0.05 to 1 for sphere and bust of skin and milk.
constexpr double faint = 0.3;

}  // namespace

PathCounts& PathCounts::operator+=(const PathCounts& o) {
  walks += o.walks, scatterings += o.scatterings, reflections += o.reflections, exits += o.exits;
  roulette_ends += o.roulette_ends, connections += o.connections, searches_skipped += o.searches_skipped;
  lost += o.lost;
  search.nodes += o.search.nodes, search.facets += o.search.facets, search.rays_found += o.search.rays_found;
  rays.boundary += o.rays.boundary, rays.shadow += o.rays.shadow;
  chain.chains += o.chain.chains, chain.links += o.chain.links, chain.trials += o.chain.trials;
  chain.trials_given_up += o.chain.trials_given_up;
  return *this;
}

WalkMedium::WalkMedium(const Scene& scene, const RayScene& rays, int object, const PathLights& lights)
    : interior(scene, rays, object), channels(interior.material()), g(interior.material().g) {
  for (std::size_t i = 0; i < lights.size(); ++i)
    chains.push_back(lights.is_environment(i) ? LightChains(interior)
                                              : LightChains(interior, lights, i, channels.smallest_sigma_t));
}

Rgb MediumWalk::radiance(const glm::dvec3& point, std::uint32_t facet, const glm::dvec3& w_o, int lead) {
  const glm::dvec3& normal = medium_.interior.facet(facet).normal;
  const double cosine = glm::dot(normal, w_o);
  if (cosine <= 0) return Rgb(0);
  const auto u = direction_inside(w_o, normal, eta_);
  if (!u) return Rgb(0);
  ++counts_.walks;
  light_lamps(point);
  State state{point, -*u, PathWeights(medium_.channels, lead)};
  return fresnel_transmittance(std::min(cosine, 1.0), eta_) / (eta_ * eta_) * walk(state);
}

void MediumWalk::light_lamps(const glm::dvec3& point) {
  lamps_.resize(lights_.size());
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (lights_.is_environment(i)) continue;
    lamps_[i].lamp = lights_.lamp(i, random_);
    lamps_[i].chain = medium_.chains[i].draw(lamps_[i].lamp, point, random_, counts_.rays, counts_.chain);
  }
}

Rgb MediumWalk::walk(State& state) {
  Rgb sum(0);
  for (;;) {
    const double flight = -std::log(random_()) / state.weights.lead_extinction();
    const auto hit = medium_.interior.boundary(state.position, state.direction, counts_.rays);
    if (!hit) {
      ++counts_.lost;
      return sum;
    }
    const double length = std::min(flight, hit->distance);
    state.position += length * state.direction;
    state.weights.fly(length);
    if (flight < hit->distance) {
      ++counts_.scatterings;
      ++state.scatterings;
      state.reflections = 0;
      state.weights.scatter();
      sum += scattered_light(state);
      if (!state.weights.survives(random_())) {
        ++counts_.roulette_ends;
        return sum;
      }
      state.direction = scattered(state.direction, medium_.g, random_);
      continue;
    }
    const Facet& facet = medium_.interior.facet(hit->facet);
    const double cosine = std::min(1.0, glm::dot(state.direction, facet.normal));
    if (!(random_() < fresnel_reflectance(cosine, 1 / eta_))) return sum + light_outside(state, facet);
    ++counts_.reflections;
    ++state.reflections;
    state.direction = mirrored(state.direction, facet.normal);
  }
}

Rgb MediumWalk::scattered_light(const State& state) {
  Rgb sum(0);
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    if (lights_.is_environment(i)) {
      sum += refracted_light(state, i, lights_.lamp(i, random_));
    } else {
      sum += refracted_light(state, i, lamps_[i].lamp);
      if (!lamps_[i].chain.mirrors.empty()) sum += chain_light(state, i);
    }
  }
  return sum;
}

// Light over a long way through the medium is faint. A connection of length s is made with a probability
// share(s) = min(1, most e^(-sigma s)/faint) and counts 1/share; one random number for all of them turns that into a
// reach, beyond which nothing is searched.
Rgb MediumWalk::refracted_light(const State& state, std::size_t light, const Lamp& lamp) {
  const double sigma = state.weights.smallest_extinction(), most = state.weights.most() / faint;
  const double reach = std::log(most / random_()) / sigma;
  Rgb sum(0);
  if (!(reach > 0)) {
    ++counts_.searches_skipped;
    return sum;
  }
  const auto connect = [&](const RefractedRay& ray, const Facet& facet) {
    const Rgb power = lights_.power(light, lamp, ray.point);
    if (power == Rgb(0)) return;
    ++counts_.connections;
    if (!medium_.interior.free_inside(state.position, ray.u, ray.length, counts_.rays)) return;
    if (!medium_.interior.free_outside(ray.point, facet.normal, ray.l, ray.light_distance, counts_.rays)) return;
    const double phase = henyey_greenstein(glm::dot(state.direction, ray.u), medium_.g);
    const double share = std::min(1.0, most * std::exp(-sigma * ray.length));
    sum += state.weights.over(ray.length) * power * (phase * ray.irradiance / share);
  };
  medium_.interior.tree().for_each_ray(lamp.where, state.position, eta_, reach, counts_.search, connect);
  return sum;
}

Rgb MediumWalk::chain_light(const State& state, std::size_t light) {
  Rgb sum(0);
  const LampOfWalk& lamp = lamps_[light];
  medium_.chains[light].for_each_light(
      lamp.chain, lamp.lamp, state.position, random_, counts_.rays, counts_.chain, [&](const ChainLight& found) {
        const Rgb power = lights_.power(light, lamp.lamp, found.ray.point);
        const double phase = henyey_greenstein(glm::dot(state.direction, found.u), medium_.g);
        sum += state.weights.over(found.ray.length) * power *
               (phase * found.ray.irradiance * found.reflectance * found.inverse_density);
      });
  return sum;
}

Rgb MediumWalk::light_outside(const State& state, const Facet& facet) {
  ++counts_.exits;
  // Light that came in by refraction right before its first scattering is gathered at the scatterings, and so is light
  // of disks altogether but that which is never scattered.
  const bool environments = state.scatterings == 0 || state.reflections > 0, disks = state.scatterings == 0;
  if (!environments) return Rgb(0);
  const auto l = direction_outside(state.direction, facet.normal, eta_);
  if (!l) return Rgb(0);
  const Rgb light = lights_.radiance(*l, environments, disks);
  if (light == Rgb(0)) return light;
  if (!medium_.interior.free_outside(state.position, facet.normal, *l, std::numeric_limits<double>::infinity(),
                                     counts_.rays))
    return Rgb(0);
  return state.weights.over(0) * light * (eta_ * eta_);
}

}  // namespace opaline
