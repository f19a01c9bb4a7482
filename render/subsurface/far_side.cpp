#include "render/subsurface/far_side.h"

#include "render/scene/texture_coordinates.h"

#include <limits>

namespace opaline {
namespace {

constexpr float infinity = std::numeric_limits<float>::infinity();

/// Outwards, unit.
glm::vec3 facet_normal(const Mesh& mesh, std::uint32_t triangle) {
  const glm::uvec3 t = mesh.triangles[triangle];
  return glm::normalize(
      glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]));
}

float least(const glm::vec3& v) { return std::min({v.x, v.y, v.z}); }

/// The extinction that a way has at least.
float least_extinction(const MediumLayers& stack) {
  float sigma = infinity;
  for (std::size_t k = 0; k <= static_cast<std::size_t>(stack.count); ++k)
    sigma = std::min(sigma, least(stack.sigma_t[k]));
  return sigma;
}

/// Does light of that way in reach some sample? Ways change evenly along the march.
bool worth_marching(const FarSideTask& task, const MarchPoint& p, const FarSide& side, float cosine) {
  if (!(task.negligible > 0)) return true;
  const float view = std::max(glm::dot(p.plane_normal, p.w_o), least_view_cosine);
  const float length = std::min(task.medium.largest_depth / view, p.exit);
  const float shortest = std::min(side.height, side.height + length * glm::dot(p.w_o, side.normal)) / cosine;
  return shortest * least_extinction(task.medium.stack) < -std::log(task.negligible);
}

/// Where a light comes in that goes to `from`, which is inside; nothing if it is dark there, or fades on the way.
FarSide far_side(const FarSideTask& task, const MarchPoint& p, const glm::vec3& from, const MarchLight& light,
                 bool& fades, std::uint64_t& rays_cast) {
  const glm::vec3 w = light.towards(from);
  const SurfaceHit hit = task.rays.closest(from, w);
  ++rays_cast;
  const float beyond = (light.far ? infinity : glm::length(light.place - from)) - hit.distance;
  if (hit.object != task.object || !(beyond > 0)) return {};
  const glm::vec3 normal = facet_normal(task.mesh, hit.triangle), k = from + hit.distance * w;
  const float cosine = glm::dot(normal, w);
  if (!(cosine > 1e-4f)) return {};
  const FarSide side{normal, glm::dot(k - p.position, normal), uv_at(task.mesh, hit.triangle, k)};
  fades = !worth_marching(task, p, side, cosine);
  if (fades) return {};
  if (task.shadows) {
    ++rays_cast;
    if (task.rays.occluded(k + task.rays.offset() * normal, w, beyond)) return {};
  }
  return side;
}

}  // namespace

std::uint32_t facing_lights(const FramedPoint& p, const glm::vec3& face_normal, std::span<const MarchLight> lights) {
  std::uint32_t facing = 0;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    const glm::vec3 w = lights[l].towards(p.position);
    if (glm::dot(p.normal, w) > least_light_cosine && glm::dot(face_normal, w) > 0) facing |= 1u << l;
  }
  return facing;
}

std::uint32_t visible_lights(const RayScene& rays, const VisiblePoint& p, const glm::vec3& face_normal,
                             std::span<const MarchLight> lights, std::uint32_t asked, std::uint64_t& rays_cast) {
  constexpr int most_hits = 16;
  std::uint32_t visible = 0;
  const glm::vec3 from = p.position + rays.offset() * face_normal;
  for (std::size_t l = 0; l < lights.size(); ++l) {
    if (!(asked >> l & 1)) continue;
    const glm::vec3 w = lights[l].towards(p.position);
    const float until = lights[l].far ? infinity : glm::length(lights[l].place - p.position);
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

void find_far_sides(const FarSideTask& task, std::uint32_t behind, MarchPoint& p, std::uint64_t& rays_cast) {
  if (task.lights.empty()) return;
  ++rays_cast;
  const SurfaceHit hit = task.rays.closest(p.position, -p.w_o, task.rays.offset());
  if (hit.object == task.object) {
    p.exit = hit.distance;
    p.exit_cosine = std::abs(glm::dot(facet_normal(task.mesh, hit.triangle), p.w_o));
  }
  const float free_path = 1 / std::max(least(task.medium.stack.sigma_t[0]), 1e-30f);
  const glm::vec3 from = p.position - std::min(free_path, 0.5f * p.exit) * p.w_o;
  for (std::size_t l = 0; l < task.lights.size(); ++l) {
    if (!(behind >> l & 1)) continue;
    bool fades = false;
    const FarSide side = far_side(task, p, from, task.lights[l], fades, rays_cast);
    if (fades) p.faded |= 1u << l;
    if (side.normal == glm::vec3(0)) continue;
    p.far.resize(task.lights.size());
    p.far[l] = side;
    p.visible |= 1u << l, p.lights |= 1u << l;
  }
}

}  // namespace opaline
