#include "render/subsurface/march.h"

#include "render/subsurface/fast_exp.h"

#include <fmt/format.h>

#include <bit>
#include <limits>

namespace opaline {
namespace {

constexpr std::size_t most_boundaries = LayeredMedium::most_layers;

/// The plane that stands for the surface at a sample.
struct Plane {
  glm::vec3 normal, point;
};

/// One light at one sample.
struct Arrival {
  bool lit = false;
  glm::vec3 w_i{0}, power{0};    ///< direction to the light, irradiance without extinction
  glm::vec3 tau{0}, through{1};  ///< optical depth on the way, and e^-tau
  int phase_layer = -1;          ///< whose phase function `phase` is
  float phase = 0;

  float phase_in(int layer, const LayerStack& stack, const glm::vec3& w_o) {
    if (layer != phase_layer) phase = stack.phase(layer, w_i, w_o), phase_layer = layer;
    return phase;
  }
};
using Arrivals = std::array<Arrival, most_march_lights>;

/// Mean of e^-x over a way on which it goes from e0 to e1, x growing by delta.
float mean_between(float e0, float e1, float delta) {
  return std::abs(delta) > 0.02f ? (e0 - e1) / delta : e0 * mean_transmittance(delta);
}

/// One sample M of the march.
struct Sample {
  glm::vec3 m{0};
  LayerPlace place;
  float boundaries[most_boundaries] = {};
};

/// All that doesn't change along the march.
struct Ray {
  const FramedPoint& p;
  const MarchMedium& medium;
  glm::vec3 plane_normal, end;
  float length;

  Plane plane_at(float t) const {
    // The print of algorithm 2 has these weights the other way round for the normal.
    const glm::vec3 n = (1 - t) * p.normal + t * plane_normal;
    const float size = glm::length(n);
    return {size > 1e-6f ? n / size : p.normal, p.position + t * p.plane_height * p.normal};
  }
};

/// The view ray down to M_max, by the least-squares plane, or by the tangent plane where that is seen edge-on.
Ray view_ray(const FramedPoint& p, const MarchMedium& medium, MarchCounts& counts) {
  glm::vec3 normal = p.plane_normal;
  float cosine = glm::dot(normal, p.w_o);
  if (cosine < least_view_cosine) {
    ++counts.grazing_points;
    normal = p.normal;
    cosine = std::max(glm::dot(normal, p.w_o), least_view_cosine);
  }
  const float length = medium.largest_depth / cosine;
  return {p, medium, normal, p.position - length * p.w_o, length};
}

Sample sample_at(const Ray& ray, float t, const Plane& plane) {
  Sample s;
  s.m = ray.p.position - t * ray.length * ray.p.w_o;
  ray.medium.boundaries(ray.p.uv_at(s.m - ray.p.position), s.boundaries);
  const float depth = std::max(glm::dot(plane.point - s.m, plane.normal), 0.0f);
  s.place = LayerPlace(depth, s.boundaries, ray.medium.stack.count);
  return s;
}

/// Light on its way from K, where it enters the plane, to M: equations 10 to 12, with the mean of the thicknesses that
/// equation 12 means.
Arrival arrival(const Ray& ray, const MarchLight& light, const Sample& s, const Plane& plane) {
  Arrival a;
  a.w_i = light.towards(s.m);
  const float cosine = glm::dot(plane.normal, a.w_i);
  if (!(cosine > 1e-4f)) return a;
  a.lit = true;
  a.power = light.irradiance(s.m);
  const float way = std::max(glm::dot(plane.point - s.m, plane.normal), 0.0f) / cosine;
  const glm::vec3 k = s.m + way * a.w_i;
  float at_k[most_boundaries];
  ray.medium.boundaries(ray.p.uv_at(k - ray.p.position), at_k);
  const LayerStack& stack = ray.medium.stack;
  float left = way, above = 0;
  for (int j = 0; j < stack.count && left > 0; ++j) {
    const float end = 0.5f * (s.boundaries[j] + at_k[j]);
    const float part = std::min(left, (end - above) / cosine);
    a.tau += part * stack.sigma_t[static_cast<std::size_t>(j)];
    left -= part, above = end;
  }
  a.tau += left * stack.sigma_t[static_cast<std::size_t>(stack.count)];
  a.through = exp_minus(a.tau);
  return a;
}

/// What light scatters on the way from one sample to the next towards the viewer, and how it fades there.
class Steps {
 public:
  Steps(const Ray& ray, float step_length) : ray_(ray), length_(step_length) {}

  /// Pieces of one layer each; optical depths change evenly along them, so that each has a closed form.
  void by_pieces(const Sample& a, const Sample& b, Arrivals& from, Arrivals& to, std::size_t lights) {
    const LayerStack& stack = ray_.medium.stack;
    for_each_piece(a.place, b.place, stack.count, [&](int layer, float t0, float t1) {
      const auto k = static_cast<std::size_t>(layer);
      const float part = (t1 - t0) * length_;
      const glm::vec3 fade = part * stack.sigma_t[k], left = through_ * exp_minus(fade);
      for (std::size_t l = 0; l < lights && stack.sigma_s[k] != glm::vec3(0); ++l)
        if (from[l].lit || to[l].lit) sum_ += stack.sigma_s[k] * piece(layer, t0, t1, part, fade, left, from[l], to[l]);
      through_ = left;
      deepest_ = std::max(deepest_, layer + 1);
    });
  }

  /// Algorithm 1 as printed: the sample's light times the step, then the step's extinction.
  void by_sample(const Sample& a, Arrivals& from, std::size_t lights) {
    const LayerStack& stack = ray_.medium.stack;
    const int layer = layer_at(a.place, stack.count);
    const auto k = static_cast<std::size_t>(layer);
    for (std::size_t l = 0; l < lights; ++l)
      if (from[l].lit)
        sum_ += stack.sigma_s[k] * from[l].power * (from[l].phase_in(layer, stack, ray_.p.w_o) * length_) * through_ *
                from[l].through;
    through_ *= exp_minus(length_ * stack.sigma_t[k]);
    deepest_ = std::max(deepest_, layer + 1);
  }

  const glm::vec3& sum() const { return sum_; }
  const glm::vec3& through() const { return through_; }  ///< transmittance from P to here
  int deepest() const { return deepest_; }

 private:
  /// One light's part of a piece, without sigma_s. `left`: what is left of the view ray's light at the piece's end.
  glm::vec3 piece(int layer, float t0, float t1, float part, const glm::vec3& fade, const glm::vec3& left,
                  Arrival& from, Arrival& to) {
    const LayerStack& stack = ray_.medium.stack;
    Arrival &x = from.lit ? from : to, &y = to.lit ? to : from;
    const float share = from.lit && to.lit ? 0.5f : 0.25f;  // the light's edge is somewhere between
    const glm::vec3 change = y.tau - x.tau, delta = fade + (t1 - t0) * change;
    const glm::vec3 e0 = through_ * (t0 == 0 ? x.through : exp_minus(x.tau + t0 * change)),
                    e1 = left * (t1 == 1 ? y.through : exp_minus(x.tau + t1 * change));
    const glm::vec3 mean(mean_between(e0.x, e1.x, delta.x), mean_between(e0.y, e1.y, delta.y),
                         mean_between(e0.z, e1.z, delta.z));
    return share * part *
           (x.phase_in(layer, stack, ray_.p.w_o) * x.power + y.phase_in(layer, stack, ray_.p.w_o) * y.power) * mean;
  }

  const Ray& ray_;
  float length_;
  glm::vec3 sum_{0}, through_{1};
  int deepest_ = 0;
};

/// Indices of the lights that are seen and reach some plane of the march: behind both ends' planes is behind all.
struct FacingLights {
  std::array<std::uint8_t, most_march_lights> index;
  std::size_t count = 0;

  FacingLights(const Ray& ray, const std::vector<MarchLight>& lights, std::uint32_t visible) {
    for (std::size_t l = 0; l < lights.size(); ++l) {
      if (!(visible >> l & 1)) continue;
      const glm::vec3 a = lights[l].towards(ray.p.position), b = lights[l].towards(ray.end);
      const auto reaches = [&](const glm::vec3& w) {
        return glm::dot(ray.p.normal, w) > 0 || glm::dot(ray.plane_normal, w) > 0;
      };
      if (reaches(a) || reaches(b)) index[count++] = static_cast<std::uint8_t>(l);
    }
  }
};

float largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }

}  // namespace

MarchMedium::MarchMedium(const LayeredMedium& medium) : textures(&medium) {
  const std::vector<double> thickness = medium.largest_thickness();
  std::vector<SubsurfaceLayer> kept;
  for (int k = 0; k < medium.count(); ++k) {
    // One layer at least stays, should the first texture's texels miss what another's show.
    const auto i = static_cast<std::size_t>(k);
    if (!(thickness[i] > 0) && (k + 1 < medium.count() || !kept.empty())) continue;
    layers.push_back(k);
    kept.push_back(medium.layers[i]);
  }
  stack = LayerStack(kept, medium.layers.back());
  largest_depth = static_cast<float>(medium.largest_depth());
}

std::vector<MarchLight> march_lights(const Scene& scene) {
  std::vector<MarchLight> lights;
  for (const Light& light : scene.lights) {
    MarchLight m;
    if (const auto* far = std::get_if<DirectionalLight>(&light))
      m = {true, glm::vec3(-far->direction), glm::vec3(far->irradiance)};
    if (const auto* point = std::get_if<PointLight>(&light))
      m = {false, glm::vec3(point->position), glm::vec3(point->intensity)};
    if (m.power != glm::vec3(0)) lights.push_back(m);
  }
  return lights;
}

std::uint32_t visible_lights(const RayScene& rays, const VisiblePoint& p, const glm::vec3& face_normal,
                             const std::vector<MarchLight>& lights, std::uint64_t& rays_cast) {
  constexpr int most_hits = 16;
  std::uint32_t visible = 0;
  const glm::vec3 from = p.position + rays.offset() * face_normal;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    const glm::vec3 w = lights[l].towards(p.position);
    const float until =
        lights[l].far ? std::numeric_limits<float>::infinity() : glm::length(lights[l].place - p.position);
    const bool faces = glm::dot(face_normal, w) > 0;
    float near = 0;
    bool blocked = false;
    for (int hit = 0; hit < most_hits && !blocked; ++hit) {
      ++rays_cast;
      const SurfaceHit found = rays.closest(from, w, near);
      if (found.object < 0 || found.distance > until) break;
      blocked = faces || found.object != p.object;
      near = found.distance + rays.offset();
    }
    if (!blocked) visible |= 1u << l;
  }
  return visible;
}

std::string march_not_applicable(const Scene& scene) {
  if (march_lights(scene).size() > most_march_lights)
    return fmt::format("it takes at most {} lights", most_march_lights);
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    const auto* far = std::get_if<DirectionalLight>(&scene.lights[i]);
    if (std::holds_alternative<PointLight>(scene.lights[i]) || (far && far->angular_radius_deg == 0)) continue;
    return fmt::format(
        "light {} has extent or a pattern; it takes directional lights without angular radius and points", i);
  }
  return {};
}

glm::vec3 march(const FramedPoint& p, const MarchMedium& medium, const std::vector<MarchLight>& all,
                std::uint32_t visible, const MarchSettings& settings, MarchCounts& counts) {
  const Ray ray = view_ray(p, medium, counts);
  const FacingLights lights(ray, all, visible);
  const auto n = static_cast<std::uint64_t>(settings.samples);
  const auto seen = static_cast<std::size_t>(std::popcount(visible & ((1u << all.size()) - 1)));
  counts.light_paths_shadowed += (all.size() - seen) * n;
  counts.light_paths_from_behind += (seen - lights.count) * n;
  if (lights.count == 0) return glm::vec3(0);
  Arrivals arrivals[2];
  Sample samples[2];
  // The sample at a share of the way, and what light there is.
  const auto advance = [&](float t, std::size_t into) {
    const Plane plane = ray.plane_at(t);
    samples[into] = sample_at(ray, t, plane);
    for (std::size_t l = 0; l < lights.count; ++l)
      arrivals[into][l] = arrival(ray, all[lights.index[l]], samples[into], plane);
  };
  Steps steps(ray, ray.length / static_cast<float>(settings.samples));
  advance(0, 0);
  for (std::uint64_t i = 1; i <= n; ++i) {
    const std::size_t to = i % 2, from = 1 - to;
    advance(static_cast<float>(i) / static_cast<float>(n), to);
    ++counts.samples, counts.light_paths += lights.count;
    if (settings.by_pieces)
      steps.by_pieces(samples[from], samples[to], arrivals[from], arrivals[to], lights.count);
    else
      steps.by_sample(samples[from], arrivals[from], lights.count);
    if (largest(steps.through()) < settings.negligible) {
      counts.samples_negligible += n - i;
      break;
    }
  }
  counts.deepest = std::max(counts.deepest, steps.deepest());
  return largest(steps.sum()) < 1e30f ? steps.sum() : glm::vec3(0);
}

}  // namespace opaline
