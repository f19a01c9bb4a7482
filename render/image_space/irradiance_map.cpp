#include "render/image_space/irradiance_map.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace opaline {
namespace {

struct Rectangle {
  int x0 = std::numeric_limits<int>::max(), y0 = x0, x1 = -1, y1 = -1;  ///< inclusive
};

Rectangle covered(const GBuffer& view, int object) {
  Rectangle r;
  for (const VisiblePoint& p : view.points) {
    if (p.object != object) continue;
    const int x = static_cast<int>(p.pixel) % view.width, y = static_cast<int>(p.pixel) / view.width;
    r = {std::min(r.x0, x), std::min(r.y0, y), std::max(r.x1, x), std::max(r.y1, y)};
  }
  return r;
}

/// The plane of a pixel's surface, as depth and slopes on the film, and its factor G.
struct Plane {
  float depth, slope_x, slope_y, g;
};

Plane orthographic_plane(const Projection& view, const glm::vec3& p, const glm::vec3& n) {
  const float cosine = std::max(std::abs(n.z), min_texel_cosine);
  // n . (p + step) constant: dz = -(n_x dx + n_y dy) / n_z, and film y points down.
  const float across = 1 / (std::copysign(cosine, n.z) * view.scale);
  return {p.z, -n.x * across, n.y * across, 1 / cosine};
}

Plane perspective_plane(const Projection& view, const glm::vec3& p, const glm::vec3& n) {
  const float distance = glm::length(p), facing = glm::dot(n, p);
  const float bounded = std::copysign(std::max(std::abs(facing), min_texel_cosine * distance), facing);
  // n . p = facing on the plane, with p = z (X, Y, 1): 1/z = (n_x X + n_y Y + n_z) / facing.
  Plane plane{1 / p.z, n.x / (bounded * view.scale), -n.y / (bounded * view.scale),
              distance * distance * distance / std::abs(bounded)};
  // The plane must not pass the viewer within the pixel.
  const float change = std::abs(plane.slope_x) + std::abs(plane.slope_y);
  if (change > plane.depth) plane.slope_x *= plane.depth / change, plane.slope_y *= plane.depth / change;
  return plane;
}

glm::vec3 face_normal(const Mesh& mesh, std::uint32_t triangle) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 a = mesh.positions[t.x];
  return glm::normalize(glm::cross(mesh.positions[t.y] - a, mesh.positions[t.z] - a));
}

/// True if there is any light.
bool write_texel(const IrradianceMap& map, const VisiblePoint& point, const Mesh& mesh, const float* e, bool weighted,
                 float* texel) {
  const Projection& view = map.projection;
  const glm::vec3 p = view.point(point.position), n = view.direction(face_normal(mesh, point.triangle));
  const Plane plane = view.perspective ? perspective_plane(view, p, n) : orthographic_plane(view, p, n);
  texel[0] = plane.depth, texel[1] = plane.slope_x, texel[2] = plane.slope_y;
  bool lit = false;
  for (int c = 0; c < map.channels; ++c) {
    texel[3 + c] = weighted ? e[c] * plane.g : e[c];
    lit = lit || e[c] > 0;
  }
  return lit;
}

IrradianceMap empty_map(const GBuffer& view, const Rectangle& r, int channels) {
  IrradianceMap map;
  map.projection = projection_of(view.camera, view.width, view.height);
  map.projection.cx -= static_cast<float>(r.x0), map.projection.cy -= static_cast<float>(r.y0);
  map.width = r.x1 - r.x0 + 1, map.height = r.y1 - r.y0 + 1;
  map.channels = channels;
  map.texels.assign(static_cast<std::size_t>(map.width * map.height * map.stride()), IrradianceMap::off_object);
  return map;
}

}  // namespace

IrradianceMap make_irradiance_map(const Scene& scene, const GBuffer& view, const ViewIrradiance& irradiance, int object,
                                  bool weighted) {
  const Rectangle r = covered(view, object);
  if (r.x1 < 0) return {};
  IrradianceMap map = empty_map(view, r, irradiance.channels);
  const Mesh& mesh = scene.objects[static_cast<std::size_t>(object)].mesh;
  std::atomic<bool> lit = false;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, view.points.size(), 1024), [&](const auto& range) {
    bool any = false;
    for (std::size_t i = range.begin(); i != range.end(); ++i) {
      const VisiblePoint& point = view.points[i];
      if (point.object != object) continue;
      const float* e = &irradiance.values[i * static_cast<std::size_t>(map.channels)];
      const int x = static_cast<int>(point.pixel) % view.width - r.x0,
                y = static_cast<int>(point.pixel) / view.width - r.y0;
      any = write_texel(map, point, mesh, e, weighted,
                        &map.texels[static_cast<std::size_t>((y * map.width + x) * map.stride())]) ||
            any;
    }
    if (any) lit = true;
  });
  map.lit = lit;
  return map;
}

}  // namespace opaline
