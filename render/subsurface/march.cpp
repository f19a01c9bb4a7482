#include "render/subsurface/march.h"

#include <fmt/format.h>

#include <bit>

namespace opaline {
namespace {

/// (a, b, c, 1 for Schlick): c / (a + |b| x)^2, or ^(3/2) for Henyey and Greenstein, x = 1 - cos, or 1 + cos for b < 0.
glm::vec4 phase_coefficients(const SubsurfaceLayer& layer) {
  const double g = std::clamp(layer.g, -0.9999, 0.9999), c = (1 - g) * (1 + g) / (4 * pi), least = 1 - std::abs(g);
  const bool schlick = layer.phase == Phase::schlick;
  return {schlick ? least : least * least, schlick ? g : 2 * g, c, schlick ? 1 : 0};
}

/// Exact: the plane at a sample has a normal, and the light from it a direction, that lie between those at the ends.
bool reaches_planes(const MarchLight& light, const FramedPoint& p, const glm::vec3& end) {
  for (const glm::vec3& w : {light.towards(p.position), light.towards(end)})
    if (glm::dot(p.normal, w) > 0 || glm::dot(p.plane_normal, w) > 0) return true;
  return false;
}

}  // namespace

MarchMedium::MarchMedium(const LayeredMedium& medium) : source(&medium) {
  const std::vector<double> thickness = medium.largest_thickness();
  std::vector<SubsurfaceLayer> kept;
  phases.fill({1, 0, 0, 1});  // nothing, but finite, below the last layer
  for (int k = 0; k < medium.count(); ++k) {
    // One layer at least stays, should the first texture's texels miss what another's show.
    const auto i = static_cast<std::size_t>(k);
    if (!(thickness[i] > 0) && (k + 1 < medium.count() || !kept.empty())) continue;
    phases[layers.size()] = phase_coefficients(medium.layers[i]);
    layers.push_back(k);
    kept.push_back(medium.layers[i]);
  }
  stack = MediumLayers(kept, medium.layers.back());
  largest_depth = static_cast<float>(medium.largest_depth());
  for (std::size_t t = 0; t < medium.depths.size(); ++t)
    if (LayerTexture texture = make_layer_texture(medium, t, layers); texture.layers > 0)
      textures.push_back(std::move(texture));
}

MarchPoint march_point(const FramedPoint& framed, const MarchMedium& medium, std::span<const MarchLight> lights,
                       std::uint32_t visible) {
  MarchPoint p;
  static_cast<FramedPoint&>(p) = framed;
  p.grazing = glm::dot(p.plane_normal, p.w_o) < least_view_cosine;
  if (p.grazing) p.plane_normal = p.normal;
  const float cosine = std::max(glm::dot(p.plane_normal, p.w_o), least_view_cosine);
  const glm::vec3 end = p.position - medium.largest_depth / cosine * p.w_o;
  p.visible = visible & ((1u << lights.size()) - 1);
  for (std::size_t l = 0; l < lights.size(); ++l)
    if ((p.visible >> l & 1) && reaches_planes(lights[l], p, end)) p.lights |= 1u << l;
  return p;
}

void MarchCounts::add(const MarchPoint& p, const MarchResult& result, int count, std::size_t lights) {
  const auto n = static_cast<std::uint64_t>(count), steps = static_cast<std::uint64_t>(result.steps);
  const auto seen = static_cast<std::uint64_t>(std::popcount(p.visible)),
             faded = static_cast<std::uint64_t>(std::popcount(p.faded)),
             reaching = static_cast<std::uint64_t>(std::popcount(p.lights));
  const auto paths = static_cast<std::uint64_t>(result.light_paths),
             behind = static_cast<std::uint64_t>(result.from_behind);
  const std::uint64_t places = 1 + (reaching > 0 ? steps : n);
  samples += steps;
  (reaching > 0 ? samples_negligible : samples_unlit) += n - steps;
  light_paths += paths;
  shadowed += (lights - seen - faded) * places;
  from_behind += behind + (seen + faded - reaching) * places;
  if (reaching > 0) below_layers += reaching * places - paths - behind;
  grazing_points += p.grazing;
  deepest = std::max(deepest, static_cast<int>(result.deepest));
}

MarchCounts& MarchCounts::operator+=(const MarchCounts& o) {
  samples += o.samples, light_paths += o.light_paths, shadow_rays += o.shadow_rays, far_side_rays += o.far_side_rays;
  samples_negligible += o.samples_negligible, samples_unlit += o.samples_unlit;
  from_behind += o.from_behind, shadowed += o.shadowed, below_layers += o.below_layers;
  grazing_points += o.grazing_points;
  deepest = std::max(deepest, o.deepest);
  return *this;
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

}  // namespace opaline
