#include "render/image_space/irradiance_map.h"

#include <algorithm>
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
  for (std::size_t i = 0; i < view.points.size(); ++i) {
    const VisiblePoint& point = view.points[i];
    if (point.object != object) continue;
    const int x = static_cast<int>(point.pixel) % view.width - r.x0,
              y = static_cast<int>(point.pixel) / view.width - r.y0;
    const glm::vec3 p = map.projection.point(point.position),
                    n = map.projection.direction(face_normal(mesh, point.triangle));
    const Plane plane =
        map.projection.perspective ? perspective_plane(map.projection, p, n) : orthographic_plane(map.projection, p, n);
    float* texel = &map.texels[static_cast<std::size_t>((y * map.width + x) * map.stride())];
    texel[0] = plane.depth, texel[1] = plane.slope_x, texel[2] = plane.slope_y;
    for (int c = 0; c < map.channels; ++c) {
      const float e = irradiance.values[i * static_cast<std::size_t>(map.channels) + static_cast<std::size_t>(c)];
      texel[3 + c] = weighted ? e * plane.g : e;
      map.lit = map.lit || e > 0;
    }
  }
  return map;
}

}  // namespace opaline
