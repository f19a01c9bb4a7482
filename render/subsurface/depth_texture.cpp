#include "render/subsurface/depth_texture.h"

#include "render/visibility/ray_scene.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace opaline {
namespace {

/// A layer's mesh, alone in a scene of its own.
struct LayerRays {
  Scene scene;
  std::unique_ptr<RayScene> rays;

  explicit LayerRays(const Mesh& mesh) {
    scene.materials.emplace_back();
    scene.objects.push_back({"layer", mesh, 0});
    rays = std::make_unique<RayScene>(scene);
  }
};

/// The place on the surface that a texel stands for.
struct TexelPlace {
  bool covered = false;
  glm::vec3 position{0}, normal{0};
};

double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Calls visit(x, y, weights of the corners) for the texels whose centres lie in a triangle of texture space; x and y
/// may be outside the image, which repeats.
template <typename Visit>
void for_each_texel(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, Visit&& visit) {
  const double area = cross(b - a, c - a);
  if (area == 0) return;
  const glm::dvec2 lo = glm::min(a, glm::min(b, c)), hi = glm::max(a, glm::max(b, c));
  for (int y = static_cast<int>(std::ceil(lo.y - 0.5)); y + 0.5 <= hi.y; ++y)
    for (int x = static_cast<int>(std::ceil(lo.x - 0.5)); x + 0.5 <= hi.x; ++x) {
      const glm::dvec2 p(x + 0.5, y + 0.5);
      const double v = cross(p - a, c - a) / area, w = cross(b - a, p - a) / area, u = 1 - v - w;
      if (u >= 0 && v >= 0 && w >= 0) visit(x, y, glm::vec3(u, v, w));
    }
}

/// Row 0 at v = 0.
std::vector<TexelPlace> texel_places(const Mesh& mesh, int width, int height, Counters& counters) {
  std::vector<TexelPlace> places(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const glm::dvec2 size(width, height);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3 k = mesh.triangles[t];
    const auto corner = [&](std::uint32_t i) { return glm::clamp(glm::dvec2(mesh.uvs[i]), -16.0, 16.0) * size; };
    for_each_texel(corner(k.x), corner(k.y), corner(k.z), [&](int x, int y, const glm::vec3& w) {
      const int column = (x % width + width) % width, line = (y % height + height) % height;
      TexelPlace& place =
          places[static_cast<std::size_t>(line) * static_cast<std::size_t>(width) + static_cast<std::size_t>(column)];
      if (place.covered) {
        ++counters.skipped["texels_covered_again"];
        return;
      }
      const SurfacePoint p = surface_point(mesh, t, w.y, w.z);
      place = {true, p.position, p.normal};
    });
  }
  return places;
}

/// Texels without a value get the mean of those around them that have one.
void fill_holes(int width, int height, std::vector<std::uint8_t>& known, std::vector<std::vector<float>>& depths) {
  for (bool changed = true; changed;) {
    changed = false;
    const std::vector<std::uint8_t> before = known;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const auto at = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        if (before[at]) continue;
        std::vector<std::size_t> near;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) {
            const int v = y + dy, u = (x + dx + width) % width;
            if (v < 0 || v >= height) continue;
            const auto other =
                static_cast<std::size_t>(v) * static_cast<std::size_t>(width) + static_cast<std::size_t>(u);
            if (before[other]) near.push_back(other);
          }
        if (near.empty()) continue;
        for (std::vector<float>& layer : depths) {
          float sum = 0;
          for (const std::size_t i : near) sum += layer[i];
          layer[at] = sum / static_cast<float>(near.size());
        }
        known[at] = 1, changed = true;
      }
  }
}

std::vector<Image> as_images(const std::vector<std::vector<float>>& depths, int width, int height) {
  const std::vector<std::string> names = {"R", "G", "B", "A"};
  std::vector<Image> images;
  for (std::size_t first = 0; first < depths.size(); first += 4) {
    const std::size_t channels = std::min<std::size_t>(4, depths.size() - first);
    Image image(width, height, {names.begin(), names.begin() + static_cast<std::ptrdiff_t>(channels)});
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        for (std::size_t c = 0; c < channels; ++c)
          image.at(x, height - 1 - y, static_cast<int>(c)) =
              depths[first + c]
                    [static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    images.push_back(std::move(image));
  }
  return images;
}

}  // namespace

std::vector<Image> make_depth_textures(const Mesh& surface, std::span<const Mesh> layers, int width, int height,
                                       double largest_depth, Counters& counters) {
  const std::vector<TexelPlace> places = texel_places(surface, width, height, counters);
  std::vector<std::vector<float>> depths(layers.size(), std::vector<float>(places.size(), 0));
  std::vector<std::uint8_t> known(places.size());
  for (std::size_t i = 0; i < places.size(); ++i) known[i] = places[i].covered;
  const auto covered = static_cast<std::uint64_t>(std::count(known.begin(), known.end(), 1));
  const auto most = static_cast<float>(largest_depth);
  for (std::size_t k = 0; k < layers.size(); ++k) {
    const LayerRays layer(layers[k]);
    tbb::parallel_for(std::size_t{0}, places.size(), [&](std::size_t i) {
      if (!known[i]) return;
      const SurfaceHit hit = layer.rays->closest(places[i].position, -places[i].normal);
      const float depth = hit.object < 0 ? most : std::min(hit.distance, most);
      depths[k][i] = std::max(depth, k > 0 ? depths[k - 1][i] : 0.0f);
    });
    counters.done["rays"] += covered;
  }
  counters.skipped["texels_off_surface"] += places.size() - covered;
  fill_holes(width, height, known, depths);
  return as_images(depths, width, height);
}

}  // namespace opaline
