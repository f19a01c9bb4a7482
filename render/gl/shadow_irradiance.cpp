#include "render/gl/shadow_irradiance.h"

#include "model/fresnel.h"
#include "render/gl/clip_matrix.h"
#include "render/image_space/light_views.h"
#include "render/image_space/projection.h"
#include "render/input_error.h"
#include "render/irradiance/light_sampler.h"
#include "render/visibility/convexity.h"

#include <glad/gl.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace opaline::gl {
namespace {

constexpr int fresnel_texels = 4096;

std::vector<float> fresnel_row(double eta) {
  std::vector<float> row(4 * fresnel_texels);
  for (int i = 0; i < fresnel_texels; ++i)
    row[static_cast<std::size_t>(4 * i)] =
        static_cast<float>(fresnel_transmittance(static_cast<double>(i) / (fresnel_texels - 1), eta));
  return row;
}

/// InputError if the light can have no shadow map.
void check_light(const Scene& scene, std::size_t i) {
  const std::string place = "/lights/" + std::to_string(i);
  const auto* directional = std::get_if<DirectionalLight>(&scene.lights[i]);
  if (std::holds_alternative<EnvironmentLight>(scene.lights[i]) || (directional && directional->angular_radius_deg > 0))
    throw InputError(scene.path, place, "a shadow map needs a light without extent; use irradiance=traced");
  if (!light_camera(scene.lights[i], scene))
    throw InputError(scene.path, place, "the light is too near the scene for a shadow map; use irradiance=traced");
}

std::unique_ptr<Texture2D> image_texture(const Context& context, const Light& light) {
  const auto* projector = std::get_if<ProjectorLight>(&light);
  if (!projector || !projector->image) return std::make_unique<Texture2D>(context, 1, 1, Format::rgba32f);
  const Image& image = *projector->image;
  const int r = image.channel("R"), g = image.channel("G"), b = image.channel("B");
  const bool rgb = r >= 0 && g >= 0 && b >= 0;
  std::vector<float> texels;
  texels.reserve(4 * image.pixel_count());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      texels.insert(texels.end(),
                    {image.at(x, y, rgb ? r : 0), image.at(x, y, rgb ? g : 0), image.at(x, y, rgb ? b : 0), 0});
  return std::make_unique<Texture2D>(context, image.width, image.height, Format::rgba32f, texels.data());
}

void add(std::vector<float>& texels, std::uint32_t pixel, const glm::vec3& v, float w) {
  float* texel = &texels[4 * static_cast<std::size_t>(pixel)];
  texel[0] = v.x, texel[1] = v.y, texel[2] = v.z, texel[3] = w;
}

}  // namespace

struct ShadowIrradiance::PointTextures {
  Texture2D points, normals, face_normals;

  static PointTextures of(const Context& context, const Scene& scene, const GBuffer& view) {
    const std::size_t count = 4 * static_cast<std::size_t>(view.width * view.height);
    std::vector<float> points(count, -1), normals(count), face_normals(count);
    for (const VisiblePoint& p : view.points) {
      const SurfacePoint s =
          surface_point_at(scene.objects[static_cast<std::size_t>(p.object)].mesh, p.triangle, p.position);
      add(points, p.pixel, p.position, static_cast<float>(p.object));
      add(normals, p.pixel, s.normal, 0);
      add(face_normals, p.pixel, s.face_normal, 0);
    }
    const auto upload = [&](const std::vector<float>& texels) {
      return Texture2D(context, view.width, view.height, Format::rgba32f, texels.data());
    };
    return {upload(points), upload(normals), upload(face_normals)};
  }
};

ShadowIrradiance::ShadowIrradiance(const Context& context, const Scene& scene, int map_pixels)
    : context_(context),
      scene_(scene),
      depth_program_(context, {{StageKind::vertex, {shader_file("render/gl/depth_only.vert")}},
                               {StageKind::fragment, {shader_file("render/gl/depth_only.frag")}}}),
      light_program_(context, {{StageKind::vertex, {shader_file("render/gl/fullscreen.vert")}},
                               {StageKind::fragment, {shader_file("render/gl/shadow_irradiance.frag")}}}),
      film_(context, {}) {
  const bool unshadowed = nothing_in_shadow(scene);
  for (std::size_t i = 0; i < scene.lights.size(); ++i) {
    check_light(scene, i);
    LightMap map;
    map.image = image_texture(context, scene.lights[i]);
    if (!unshadowed) {
      const Projection view = projection_of(*light_camera(scene.lights[i], scene), map_pixels, map_pixels);
      map.to_clip = clip_matrix(scene, view, map_pixels, map_pixels);
      map.scale = view.scale;
      map.depth = std::make_unique<Texture2D>(context, map_pixels, map_pixels, Format::depth32f);
      draw_depth(scene, map);
    }
    maps_.push_back(std::move(map));
  }
  for (const Object& object : scene.objects) {
    const double eta = scene.materials[static_cast<std::size_t>(object.material)].eta;
    if (!fresnel_.count(eta)) fresnel_[eta] = std::make_unique<Texture1D>(context, fresnel_row(eta));
  }
}

void ShadowIrradiance::draw_depth(const Scene& scene, LightMap& map) const {
  const Framebuffer target(context_, {}, map.depth.get());
  target.clear();
  depth_program_.set("to_clip", map.to_clip);
  for (const Object& object : scene.objects) {
    const Buffer positions(context_, object.mesh.positions), triangles(context_, object.mesh.triangles);
    const Buffer* attributes[] = {&positions};
    const VertexArray mesh(context_, attributes, &triangles);
    depth_program_.use();
    mesh.draw_indexed(object.mesh.triangles.size());
  }
  context_.check_errors();
}

void ShadowIrradiance::set_light(const Light& light, const LightMap& map) const {
  const Program& p = light_program_;
  p.set("shadows", int{map.depth != nullptr});
  p.set("to_clip", map.to_clip);
  p.set("map_scale", map.scale);
  if (const auto* l = std::get_if<DirectionalLight>(&light)) {
    p.set("kind", 0);
    p.set("colour", glm::vec3(l->irradiance));
    p.set("direction", glm::vec3(l->direction));
  } else if (const auto* point = std::get_if<PointLight>(&light)) {
    p.set("kind", 1);
    p.set("colour", glm::vec3(point->intensity));
    p.set("position", glm::vec3(point->position));
  } else {
    const auto& projector = std::get<ProjectorLight>(light);
    const glm::dvec3 forward = glm::normalize(projector.look_at - projector.position),
                     right = glm::normalize(glm::cross(forward, projector.up));
    const double half = std::tan(projector.fov_y_deg * pi / 360),
                 aspect = projector.image ? static_cast<double>(projector.image->width) / projector.image->height : 1;
    p.set("kind", projector.image ? 3 : 2);
    p.set("colour", glm::vec3(projector.intensity));
    p.set("position", glm::vec3(projector.position));
    p.set("direction", glm::vec3(forward));
    p.set("right", glm::vec3(right));
    p.set("up", glm::vec3(glm::cross(right, forward)));
    p.set("tangents", projector.image ? glm::vec2(half * aspect, half)
                                      : glm::vec2(glm::dvec2(std::tan(projector.disk_radius_deg * pi / 180))));
  }
}

ViewIrradiance ShadowIrradiance::at(const GBuffer& view, Counters& counters) const {
  const PointTextures points = PointTextures::of(context_, scene_, view);
  const Texture2D sum(context_, view.width, view.height, Format::rgba32f);
  const Texture2D* targets[] = {&sum};
  const Framebuffer target(context_, targets);
  target.clear();
  const char* names[] = {"points", "normals", "face_normals", "image", "transmittance", "shadow"};
  for (int unit = 0; unit < 6; ++unit) light_program_.set(names[unit], unit);
  points.points.bind(0), points.normals.bind(1), points.face_normals.bind(2);
  target.bind();
  const GladGLContext& gl = context_.use();
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_ONE, GL_ONE);
  for (std::size_t i = 0; i < maps_.size(); ++i) {
    set_light(scene_.lights[i], maps_[i]);
    maps_[i].image->bind(3);
    if (maps_[i].depth) maps_[i].depth->bind(5);
    for (std::size_t object = 0; object < scene_.objects.size(); ++object) {
      const auto material = static_cast<std::size_t>(scene_.objects[object].material);
      fresnel_.at(scene_.materials[material].eta)->bind(4);
      light_program_.set("object", static_cast<float>(object));
      light_program_.use();
      film_.draw_triangles(3);
    }
    ++(maps_[i].depth ? counters.done["shadow_maps"] : counters.skipped["shadow_maps_nothing_in_shadow"]);
  }
  gl.Disable(GL_BLEND);
  context_.check_errors();

  ViewIrradiance irradiance;
  irradiance.channels = LightSampler(scene_, 1).single_colour(irradiance.colour) ? 1 : 3;
  if (irradiance.channels == 3) irradiance.colour = Rgb(1);
  const std::vector<float> e = sum.read();
  for (const VisiblePoint& p : view.points) {
    const float* rgb = &e[4 * static_cast<std::size_t>(p.pixel)];
    if (irradiance.channels == 1)
      irradiance.values.push_back(std::max({rgb[0], rgb[1], rgb[2]}));
    else
      irradiance.values.insert(irradiance.values.end(), rgb, rgb + 3);
  }
  return irradiance;
}

}  // namespace opaline::gl
