#include "render/image_space/sampled_material.h"

#include "render/irradiance/light_sampler.h"

#include <algorithm>
#include <cmath>

namespace opaline {
namespace {

constexpr std::uint32_t places = 4096;
constexpr std::size_t most = 24;
constexpr double near_enough = 0.2;

/// Materials at places spread over the triangles.
std::vector<Material> materials_over(const Object& object, const Material& material) {
  std::vector<Material> all;
  const std::size_t triangles = object.mesh.triangles.size();
  for (std::uint32_t i = 0; i < places; ++i) {
    const glm::uvec3 t = object.mesh.triangles[i * triangles / places];
    auto [u, v] = shifted_r2(1, i);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    all.push_back(
        material.at((1 - u - v) * object.mesh.uvs[t.x] + u * object.mesh.uvs[t.y] + v * object.mesh.uvs[t.z]));
  }
  return all;
}

}  // namespace

double material_distance(const Material& a, const Material& b) {
  double distance = 0;
  for (int c = 0; c < 3; ++c)
    for (const auto& [x, y] :
         {std::pair(a.sigma_a[c], b.sigma_a[c]), std::pair(a.sigma_s_prime[c], b.sigma_s_prime[c])})
      distance = std::max(distance, std::abs(std::log(std::max(x, 1e-4) / std::max(y, 1e-4))));
  return distance;
}

std::vector<Material> representative_materials(const Object& object, const Material& material) {
  if (!material.textured()) return {material};
  const std::vector<Material> all = materials_over(object, material);
  std::vector<Material> chosen;
  std::vector<double> distance(all.size(), 1e300);
  for (std::size_t next = 0; chosen.size() < most;) {
    chosen.push_back(all[next]);
    for (std::size_t i = 0; i < all.size(); ++i)
      distance[i] = std::min(distance[i], material_distance(all[i], chosen.back()));
    next = static_cast<std::size_t>(std::max_element(distance.begin(), distance.end()) - distance.begin());
    if (distance[next] <= near_enough) break;
  }
  return chosen;
}

std::size_t nearest_material(const std::vector<SampledMaterial>& all, const Material& here) {
  std::size_t best = 0;
  double least = 1e300;
  for (std::size_t i = 0; i < all.size() && all.size() > 1; ++i) {
    const double distance = material_distance(all[i].material, here);
    if (distance < least) least = distance, best = i;
  }
  return best;
}

}  // namespace opaline
