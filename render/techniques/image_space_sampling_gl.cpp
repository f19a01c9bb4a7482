// The gather of image_space_sampling in one fragment shader pass per object.
#include "render/gl/profile_family.h"
#include "render/gl/profile_texture.h"
#include "render/gl/shadow_irradiance.h"
#include "render/image_space/image_space.h"
#include "render/input_error.h"
#include "render/scene/texture_coordinates.h"
#include "render/visibility/convexity.h"

#include <algorithm>
#include <functional>

namespace opaline {
namespace {

using gl::Format;
using gl::Texture2D;

/// Samples: a row per set.
struct SampleTextures {
  Texture2D places, shares;
};

void add_rows(const SampleSets& sets, std::size_t width, std::vector<float>& places, std::vector<float>& shares) {
  for (const SampleSet& set : sets.sets) {
    for (std::size_t i = 0; i < width; ++i) {
      const bool real = i < set.count;
      places.insert(places.end(), {real ? set.u[i] : 0, real ? set.v[i] : 0, real ? set.weight[i] : 0, 0});
      for (std::size_t t = 0; t < 3; ++t) shares.push_back(real ? set.share[t][i] : 0);
      shares.push_back(0);
    }
  }
}

/// Per representative material the importance sets and the combined ones; where only one kind is used it stands for
/// both.
std::unique_ptr<SampleTextures> sample_textures(const gl::Context& context, const ImageSpaceObject& object,
                                                const ImageSpaceSettings& settings) {
  std::vector<float> places, shares;
  const auto width = static_cast<std::size_t>(settings.samples);
  for (const SampledMaterial& m : object.materials) {
    add_rows(m.importance.sets.empty() ? m.combined : m.importance, width, places, shares);
    add_rows(m.combined.sets.empty() ? m.importance : m.combined, width, places, shares);
  }
  const int rows = 2 * settings.pattern * settings.pattern * static_cast<int>(object.materials.size());
  return std::unique_ptr<SampleTextures>(
      new SampleTextures{Texture2D(context, settings.samples, rows, Format::rgba32f, places.data()),
                         Texture2D(context, settings.samples, rows, Format::rgba32f, shares.data())});
}

/// The irradiance image and the points to shade, texel by texel of an object's rectangle.
struct ObjectImages {
  std::vector<float> texels, more_light, points, normals;
  std::vector<float> scales, family;        ///< of a textured object
  std::vector<std::size_t> representative;  ///< of each point
};

ObjectImages object_images(const IrradianceMap& map, const GBuffer& view, const ObjectPoints& points,
                           const std::vector<std::uint8_t>& combined, const glm::ivec2& corner) {
  const auto count = static_cast<std::size_t>(map.width * map.height), stride = static_cast<std::size_t>(map.stride());
  ObjectImages images;
  images.points.assign(4 * count, -1), images.normals.resize(4 * count);
  if (map.channels == 1) {
    images.texels = map.texels;
  } else {
    images.texels.resize(4 * count), images.more_light.resize(4 * count);
    for (std::size_t i = 0; i < count; ++i) {
      std::copy_n(&map.texels[i * stride], 4, &images.texels[4 * i]);
      std::copy_n(&map.texels[i * stride + 4], 2, &images.more_light[4 * i]);
    }
  }
  for (const std::uint32_t k : points.indices) {
    const VisiblePoint& p = view.points[k];
    const int x = static_cast<int>(p.pixel) % view.width - corner.x,
              y = static_cast<int>(p.pixel) / view.width - corner.y;
    const auto at = static_cast<std::size_t>(4 * (y * map.width + x));
    const glm::vec3 place = map.projection.point(p.position), normal = map.projection.direction(p.normal);
    for (int axis = 0; axis < 3; ++axis)
      images.points[at + static_cast<std::size_t>(axis)] = place[axis],
                         images.normals[at + static_cast<std::size_t>(axis)] = normal[axis];
    images.points[at + 3] = combined[k];
  }
  return images;
}

/// Which representative serves each point of a textured object, and where its own profiles are.
void add_materials(const Object& object, const Material& material, const ImageSpaceObject& sampled,
                   const gl::ProfileFamily& family, const GBuffer& view, const ObjectPoints& points,
                   const std::function<std::size_t(const VisiblePoint&)>& texel_of, ObjectImages& images) {
  images.scales.resize(images.points.size()), images.family.resize(images.points.size());
  for (const std::uint32_t k : points.indices) {
    const VisiblePoint& p = view.points[k];
    const Material here = material.at(uv_at(object.mesh, p.triangle, p.position));
    images.representative.push_back(nearest_material(sampled.materials, here));
    const std::size_t at = 4 * texel_of(p);
    images.points[at + 3] += 2 * static_cast<float>(images.representative.back());
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::vec2 place = family.place(here.channel(static_cast<int>(c)));
      images.scales[at + c] = place.x, images.family[at + c] = place.y;
    }
  }
}

class GlSampling : public PreparedTechnique {
 public:
  GlSampling(const SharedScene& shared, const ImageSpaceSettings& settings, const gl::Context& context)
      : shared_(shared),
        settings_(settings),
        context_(context),
        unshadowed_(nothing_in_shadow(shared.scene)),
        objects_(image_space_objects(shared.scene, settings, shared.settings.irradiance.seed)),
        film_(context, {}) {
    if (settings.shadow_maps)
      shadow_maps_ = std::make_unique<gl::ShadowIrradiance>(context, shared.scene, settings.shadow_map_pixels);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      samples_.push_back(sample_textures(context, objects_[i], settings));
      const double r_max = 1.01 * diameter(shared.scene.objects[i].mesh);
      profiles_.push_back(std::make_unique<gl::ProfileTexture>(context, objects_[i].materials[0].profiles, r_max));
      families_.push_back(objects_[i].textured ? std::make_unique<gl::ProfileFamily>(
                                                     context, *find_profile(settings.profile), material(i), r_max)
                                               : nullptr);
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.exitance.assign(view.points.size(), glm::vec3(0));
    const ViewIrradiance irradiance = shadow_maps_
                                          ? shadow_maps_->at(view, frame.counters)
                                          : view_irradiance(shared_.scene, shared_.rays, view,
                                                            shared_.settings.irradiance, unshadowed_, frame.counters);
    for (std::size_t i = 0; i < objects_.size(); ++i) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(i));
      if (!points.indices.empty()) shade_object(i, view, irradiance, points, frame);
    }
    return frame;
  }

 private:
  const Material& material(std::size_t i) const {
    return shared_.scene.materials[static_cast<std::size_t>(shared_.scene.objects[i].material)];
  }

  void shade_object(std::size_t i, const GBuffer& view, const ViewIrradiance& light, const ObjectPoints& points,
                    Frame& frame) const {
    const bool textured = objects_[i].textured;
    const ViewIrradiance irradiance = textured ? in_colour(light) : light;
    const IrradianceMap map =
        make_irradiance_map(shared_.scene, view, irradiance, static_cast<int>(i), settings_.jacobian);
    count_object(objects_[i], frame.counters);
    if (!map.lit) return;
    const Projection whole = projection_of(view.camera, view.width, view.height);
    const glm::ivec2 corner(std::lround(whole.cx - map.projection.cx), std::lround(whole.cy - map.projection.cy));
    const std::vector<std::uint8_t> combined = combined_points(objects_[i], settings_, view, irradiance);
    ObjectImages images = object_images(map, view, points, combined, corner);
    const auto texel_of = [&](const VisiblePoint& p) {
      const int x = static_cast<int>(p.pixel) % view.width - corner.x,
                y = static_cast<int>(p.pixel) / view.width - corner.y;
      return static_cast<std::size_t>(y * map.width + x);
    };
    if (textured)
      add_materials(shared_.scene.objects[i], material(i), objects_[i], *families_[i], view, points, texel_of, images);
    const Texture2D sums(context_, map.width, map.height, Format::rgba32f),
        valid(context_, map.width, map.height, Format::rgba32f);
    draw(i, map, images, corner, sums, valid);
    const std::vector<float> sum = sums.read(),
                             share = settings_.only_valid ? valid.read() : std::vector<float>(sum.size());
    for (std::size_t k = 0; k < points.indices.size(); ++k) {
      const std::uint32_t point = points.indices[k];
      const std::size_t at = 4 * texel_of(view.points[point]);
      const SampledMaterial& m = objects_[i].materials[textured ? images.representative[k] : 0];
      frame.exitance[point] = exitance_of(m, settings_, irradiance, &sum[at], &share[at]);
    }
    frame.counters.done["samples"] += points.indices.size() * static_cast<std::uint64_t>(settings_.samples);
  }

  void draw(std::size_t i, const IrradianceMap& map, const ObjectImages& images, const glm::ivec2& corner,
            const Texture2D& sums, const Texture2D& valid) const {
    const auto upload = [&](const std::vector<float>& data) {
      return Texture2D(context_, map.width, map.height, Format::rgba32f, data.empty() ? nullptr : data.data());
    };
    const Texture2D texels = upload(images.texels), more = upload(images.more_light), points = upload(images.points),
                    normals = upload(images.normals), scales = upload(images.scales), family = upload(images.family);
    const Texture2D* inputs[] = {&texels, &more,  &points, &normals, &samples_[i]->places, &samples_[i]->shares,
                                 &scales, &family};
    const char* names[] = {"texels",        "more_light",    "points", "normals",
                           "sample_places", "sample_shares", "scales", "family_places"};
    const gl::Program& program = program_for(map, objects_[i].textured);
    for (int unit = 0; unit < 8; ++unit) {
      inputs[unit]->bind(static_cast<unsigned>(unit));
      program.set(names[unit], unit);
    }
    profiles_[i]->bind(program, 8);
    if (families_[i]) families_[i]->bind(program, 9);
    set_uniforms(program, i, map, corner);
    const Texture2D* targets[] = {&sums, &valid};
    const gl::Framebuffer target(context_, targets);
    target.bind();
    program.use();
    film_.draw_triangles(3);
    context_.check_errors();
  }

  void set_uniforms(const gl::Program& program, std::size_t i, const IrradianceMap& map,
                    const glm::ivec2& corner) const {
    program.set("film", glm::vec3(map.projection.scale, map.projection.cx, map.projection.cy));
    program.set("size", glm::ivec2(map.width, map.height));
    program.set("corner", corner);
    program.set("samples", settings_.samples);
    program.set("pattern", settings_.pattern);
    program.set("min_plane_cosine", static_cast<float>(settings_.min_plane_cosine));
    const int* table = objects_[i].materials[0].profiles.sum().table_of;
    program.set("tables", glm::vec3(table[0], table[1], table[2]));
  }

  /// The shader for a kind of view and of light, compiled when first needed.
  const gl::Program& program_for(const IrradianceMap& map, bool textured) const {
    std::unique_ptr<gl::Program>& program = programs_[map.projection.perspective][map.channels == 3][textured];
    if (program) return *program;
    std::string constants;
    const auto add = [&](const char* name, bool value) {
      constants += std::string("const bool ") + name + (value ? " = true;\n" : " = false;\n");
    };
    add("perspective", map.projection.perspective);
    add("coloured", map.channels == 3);
    add("jacobian", settings_.jacobian);
    add("count_valid", settings_.only_valid);
    add("textured", textured);
    program = std::make_unique<gl::Program>(
        context_, std::vector<gl::Stage>{{gl::StageKind::vertex, {gl::shader_file("render/gl/fullscreen.vert")}},
                                         {gl::StageKind::fragment,
                                          {{"constants", constants},
                                           gl::shader_file("render/gl/profile.glsl"),
                                           gl::shader_file("render/gl/profile_family.glsl"),
                                           gl::shader_file("render/techniques/image_space_sampling.frag")}}});
    return *program;
  }

  const SharedScene& shared_;
  ImageSpaceSettings settings_;
  const gl::Context& context_;
  bool unshadowed_;
  std::vector<ImageSpaceObject> objects_;
  mutable std::unique_ptr<gl::Program> programs_[2][2][2];  ///< by perspective, coloured, textured
  gl::VertexArray film_;
  std::unique_ptr<gl::ShadowIrradiance> shadow_maps_;  ///< null: shadow rays
  std::vector<std::unique_ptr<SampleTextures>> samples_;
  std::vector<std::unique_ptr<gl::ProfileTexture>> profiles_;
  std::vector<std::unique_ptr<gl::ProfileFamily>> families_;  ///< null for an object without maps
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_image_space_sampling_gl(const SharedScene& shared, const Settings& given,
                                                                   const gl::Context& context) {
  const ImageSpaceSettings settings = read_image_space_settings(given);
  if (settings.light_views)
    throw InputError("--set views", "", "the gpu backend has the camera's view alone; use --backend cpu");
  return std::make_unique<GlSampling>(shared, settings, context);
}

}  // namespace opaline
