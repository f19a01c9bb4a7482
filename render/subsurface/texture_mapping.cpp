#include "render/subsurface/texture_mapping.h"

#include "render/subsurface/far_side.h"
#include "render/visibility/convexity.h"

#include <fmt/format.h>

#include <cmath>

namespace opaline {
namespace {

const Material& material_of(const Scene& scene, const Object& object) {
  return scene.materials[static_cast<std::size_t>(object.material)];
}

/// Equation 8, for the channel that reaches furthest through the first layer.
double neighbourhood_radius(const MediumLayers& stack, double epsilon, const Mesh& mesh) {
  const glm::vec3& sigma_t = stack.sigma_t[0];
  const auto least = static_cast<double>(std::min({sigma_t.x, sigma_t.y, sigma_t.z}));
  glm::dvec3 lo(1e300), hi(-1e300);
  for (const glm::vec3& p : mesh.positions) lo = glm::min(lo, glm::dvec3(p)), hi = glm::max(hi, glm::dvec3(p));
  // A clear layer would take in all of the object.
  return std::min(-std::log(epsilon) / std::max(least, 1e-30), glm::length(hi - lo));
}

}  // namespace

std::vector<SettingSpec> texture_mapping_setting_specs() {
  return {
      {"samples_per_pixel", "50", "N, steps along the view ray", {}, 1, 1000, true},
      {"march",
       "pieces",
       "light fades along a step as it does, layer by layer; or the sum of samples of the paper",
       {"pieces", "paper"}},
      {"epsilon", "0.05", "of the planes' neighbourhoods: what is left of light after their radius", {}, 1e-6, 0.9},
      {"negligible", "1e-4", "transmittance at which a march ends; 0: it never does", {}, 0, 0.5},
      {"shadows", "traced", "of lights, by one ray from the point seen; off: none, as in the paper", {"traced", "off"}},
      {"far_side",
       "traced",
       "light from behind that comes through, and where the view leaves, by a ray each; none: as in the paper",
       {"traced", "none"}},
      {"reflection", "off", "light that the surface reflects, glossy", {"off", "on"}},
      {"roughness", "0.3", "of that reflection", {}, 0.02, 1}};
}

TextureMappingSettings read_texture_mapping_settings(const Settings& settings) {
  TextureMappingSettings s;
  s.march.samples = static_cast<int>(settings.number("samples_per_pixel"));
  s.march.by_pieces = settings.word("march") == "pieces";
  s.march.negligible = static_cast<float>(settings.number("negligible"));
  s.epsilon = settings.number("epsilon");
  s.shadows = settings.word("shadows") == "traced";
  s.far_side = settings.word("far_side") == "traced";
  s.reflection = settings.word("reflection") == "on";
  s.roughness = static_cast<float>(settings.number("roughness"));
  return s;
}

MappedScene make_mapped_scene(const Scene& scene, const TextureMappingSettings& settings) {
  MappedScene mapped;
  mapped.lights = march_lights(scene);
  mapped.settings = settings;
  mapped.unshadowed = !settings.shadows || nothing_in_shadow(scene);
  for (const Object& object : scene.objects) {
    const Material& material = material_of(scene, object);
    auto m = std::make_unique<MappedObject>();
    m->medium = MarchMedium(*material.layers);
    m->frames = make_surface_frames(object.mesh, neighbourhood_radius(m->medium.stack, settings.epsilon, object.mesh));
    m->reflectance = reflectance_at_normal(material.eta);
    Counters& c = mapped.counters;
    c.done["plane_neighbours"] += m->frames.neighbours;
    c.done["planes"] += object.mesh.positions.size() - m->frames.without_plane;
    c.done["tangent_planes_in_place_of_fitted"] += m->frames.without_plane;
    c.done["vertices_without_tangent_frame"] += m->frames.without_gradient;
    c.skipped["empty_layers"] += static_cast<std::uint64_t>(material.layers->count() - m->medium.stack.count);
    mapped.objects.push_back(std::move(m));
  }
  return mapped;
}

MarchPoint MappedScene::point(const SharedScene& shared, const VisiblePoint& p, MarchCounts& counts) const {
  const auto o = static_cast<std::size_t>(p.object);
  const Mesh& mesh = shared.scene.objects[o].mesh;
  const FramedPoint framed = framed_point(mesh, objects[o]->frames, p);
  const glm::vec3 face = surface_point_at(mesh, p.triangle, p.position).face_normal;
  const std::uint32_t asked = settings.far_side ? facing_lights(framed, face, lights) : ~0u;
  const std::uint32_t visible =
      unshadowed ? asked : visible_lights(shared.rays, p, face, lights, asked, counts.shadow_rays);
  MarchPoint point = march_point(framed, objects[o]->medium, lights, visible);
  if (settings.far_side)
    find_far_sides({shared.rays, mesh, p.object, objects[o]->medium, lights, settings.march.negligible, !unshadowed},
                   ~asked, point, counts.far_side_rays);
  return point;
}

Counters MappedScene::named(const MarchCounts& c, const MappedObject& object) {
  Counters counters;
  counters.done = {{"march_samples", c.samples},
                   {"light_paths", c.light_paths},
                   {"shadow_rays", c.shadow_rays},
                   {"far_side_rays", c.far_side_rays},
                   {"grazing_points", c.grazing_points}};
  const int unreached = c.samples > 0 ? object.medium.stack.count - c.deepest : 0;
  counters.skipped = {{"march_samples_behind_negligible", c.samples_negligible},
                      {"march_samples_of_unlit_points", c.samples_unlit},
                      {"light_paths_from_behind", c.from_behind},
                      {"light_paths_shadowed", c.shadowed},
                      {"light_paths_below_layers", c.below_layers},
                      {"layers_nobody_reaches", static_cast<std::uint64_t>(std::max(0, unreached))}};
  return counters;
}

std::string texture_mapping_not_applicable(const Scene& scene) {
  for (const Object& object : scene.objects)
    if (!material_of(scene, object).layers)
      return fmt::format("material '{}' has no layers", material_of(scene, object).name);
  return march_not_applicable(scene);
}

}  // namespace opaline
