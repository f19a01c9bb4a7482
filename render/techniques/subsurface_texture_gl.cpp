// The march of subsurface_texture in one fragment shader pass per object.
#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/subsurface/texture_mapping.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace opaline {
namespace {

using gl::Format;
using gl::Texture2D;

constexpr int row = 512;  ///< points side by side, so that no pixel off the object costs anything

/// A depth texture with four channels, its rows from the bottom up: t is v.
std::unique_ptr<Texture2D> depth_texture(const gl::Context& context, const SurfaceTexture& texture) {
  const Image& image = *texture.image;
  std::vector<float> texels(4 * image.pixel_count(), 0.0f);
  const auto channels = std::min<std::size_t>(image.channels.size(), 4);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      std::copy_n(&image.data[image.index(x, image.height - 1 - y, 0)], channels,
                  &texels[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) +
                               static_cast<std::size_t>(x))]);
  using Wrap = SurfaceTexture::Wrap;
  return std::make_unique<Texture2D>(
      context, image.width, image.height, Format::rgba32f, texels.data(),
      texture.filter == SurfaceTexture::Filter::nearest ? gl::Sampling::nearest : gl::Sampling::linear,
      texture.wrap == Wrap::repeat   ? gl::Wrap::repeat
      : texture.wrap == Wrap::mirror ? gl::Wrap::mirror
                                     : gl::Wrap::clamp);
}

/// Source of `boundaries`: one look-up for each texture, then each layer's channel, none less than the one above.
std::string boundaries_source(const MarchMedium& medium) {
  std::string text, read, names = "rgba";
  int have = -1;
  for (std::size_t i = 0; i < medium.layers.size(); ++i) {
    const int k = medium.layers[i], texture = k / 4;
    if (texture != have) {
      text += fmt::format("uniform sampler2D depths_{};\n", texture);
      read += fmt::format("  vec4 t{0} = textureLod(depths_{0}, uv, 0.0) * {1:.9e};\n", texture,
                          medium.textures->depth_scale);
      have = texture;
    }
    read += fmt::format("  depth[{}] = max({}, t{}.{});\n", i, i == 0 ? "0.0" : fmt::format("depth[{}]", i - 1),
                        texture, names[static_cast<std::size_t>(k % 4)]);
  }
  return text + "void boundaries(vec2 uv, out float depth[layers]) {\n" + read + "}\n";
}

/// The points of an object, a texel each, field by field.
struct PointImages {
  int height = 0;
  std::vector<float> fields[6];

  explicit PointImages(std::size_t points) : height(static_cast<int>((points + row - 1) / row)) {
    for (std::vector<float>& f : fields) f.assign(4 * static_cast<std::size_t>(row * height), 0.0f);
  }
  void put(std::size_t i, const FramedPoint& p, std::uint32_t visible) {
    const auto texel = [&](int field, const glm::vec3& v, float w) {
      std::copy_n(&v.x, 3, &fields[field][4 * i]);
      fields[field][4 * i + 3] = w;
    };
    texel(0, p.position, 1), texel(1, p.normal, p.plane_height), texel(2, p.plane_normal, p.uv.x);
    texel(3, p.gradient_u, p.uv.y), texel(4, p.gradient_v, static_cast<float>(visible)), texel(5, p.w_o, 0);
  }
};

constexpr const char* field_names[6] = {"positions", "normals", "plane_normals", "gradients_u", "gradients_v", "views"};

class GlMapping : public PreparedTechnique {
 public:
  GlMapping(const SharedScene& shared, const TextureMappingSettings& settings, const gl::Context& context)
      : shared_(shared),
        settings_(settings),
        context_(context),
        mapped_(make_mapped_scene(shared.scene, settings)),
        film_(context, {}) {
    for (const auto& object : mapped_.objects) {
      programs_.push_back(make_program(*object));
      textures_.emplace_back();
      for (const SurfaceTexture& texture : object->medium.textures->depths)
        textures_.back().push_back(depth_texture(context, texture));
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.radiance.assign(view.points.size(), glm::vec3(0));
    frame.counters = mapped_.counters;
    for (std::size_t o = 0; o < mapped_.objects.size() && !mapped_.lights.empty(); ++o) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(o));
      if (!points.indices.empty()) render_object(o, view, points.indices, frame);
    }
    return frame;
  }

 private:
  std::unique_ptr<gl::Program> make_program(const MappedObject& object) const {
    const std::string constants =
        fmt::format("const int layers = {}, lights = {}, samples = {};\nconst bool by_pieces = {}, reflection = {};\n",
                    object.medium.stack.count, std::max<std::size_t>(1, mapped_.lights.size()), settings_.march.samples,
                    settings_.march.by_pieces, settings_.reflection);
    return std::make_unique<gl::Program>(
        context_, std::vector<gl::Stage>{{gl::StageKind::vertex, {gl::shader_file("render/gl/fullscreen.vert")}},
                                         {gl::StageKind::fragment,
                                          {{"constants", constants},
                                           {"boundaries", boundaries_source(object.medium)},
                                           gl::shader_file("render/techniques/subsurface_texture.frag")}}});
  }

  void render_object(std::size_t o, const GBuffer& view, const std::vector<std::uint32_t>& indices,
                     Frame& frame) const {
    PointImages images(indices.size());
    std::vector<std::uint64_t> rays(indices.size());
    tbb::parallel_for(std::size_t{0}, indices.size(), [&](std::size_t i) {
      const VisiblePoint& p = view.points[indices[i]];
      MarchCounts counts;
      const std::uint32_t visible = mapped_.visible(shared_, p, counts) & ((1u << mapped_.lights.size()) - 1);
      rays[i] = counts.shadow_rays;
      images.put(i, framed_point(shared_.scene.objects[o].mesh, mapped_.objects[o]->frames, p), visible);
    });
    for (const std::uint64_t n : rays) frame.counters.done["shadow_rays"] += n;
    const Texture2D out(context_, row, images.height, Format::rgba32f);
    draw(o, images, out);
    const std::vector<float> result = out.read();
    double steps = 0;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      frame.radiance[indices[i]] = glm::vec3(result[4 * i], result[4 * i + 1], result[4 * i + 2]);
      steps += static_cast<double>(result[4 * i + 3]);
    }
    const auto done = static_cast<std::uint64_t>(steps);
    frame.counters.done["march_samples"] += done;
    frame.counters.skipped["march_samples_behind_negligible"] +=
        indices.size() * static_cast<std::uint64_t>(settings_.march.samples) - done;
  }

  void draw(std::size_t o, const PointImages& images, const Texture2D& out) const {
    const gl::Program& program = *programs_[o];
    std::vector<std::unique_ptr<Texture2D>> fields;
    for (const std::vector<float>& field : images.fields)
      fields.push_back(std::make_unique<Texture2D>(context_, row, images.height, Format::rgba32f, field.data()));
    int unit = 0;  // making a texture binds it to whatever unit was last in use: so all are made before
    for (const char* name : field_names) {
      fields[static_cast<std::size_t>(unit)]->bind(static_cast<unsigned>(unit));
      program.set(name, unit++);
    }
    for (std::size_t j = 0; j < textures_[o].size(); ++j) {
      textures_[o][j]->bind(static_cast<unsigned>(unit));
      program.set(fmt::format("depths_{}", j).c_str(), unit++);
    }
    set_medium(program, *mapped_.objects[o]);
    const Texture2D* targets[] = {&out};
    const gl::Framebuffer target(context_, targets);
    target.bind();
    program.use();
    film_.draw_triangles(3);
    context_.check_errors();
  }

  void set_medium(const gl::Program& program, const MappedObject& object) const {
    const auto set = [&](const char* name, std::size_t i, const auto& value) {
      program.set(fmt::format("{}[{}]", name, i).c_str(), value);
    };
    const LayerStack& stack = object.medium.stack;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(stack.count); ++k) {
      set("sigma_s", k, stack.sigma_s[k]);
      set("sigma_t", k, stack.sigma_t[k]);
      set("phase_of", k, glm::vec2(stack.g[k], stack.schlick[k] ? 1 : 0));
    }
    for (std::size_t l = 0; l < mapped_.lights.size(); ++l) {
      set("light_place", l, mapped_.lights[l].place);
      set("light_power", l, mapped_.lights[l].power);
      set("light_far", l, mapped_.lights[l].far ? 1.0f : 0.0f);
    }
    program.set("largest_depth", object.medium.largest_depth);
    program.set("negligible", settings_.march.negligible);
    program.set("least_view_cosine", least_view_cosine);
    program.set("f0", object.reflectance);
    program.set("roughness", settings_.roughness);
  }

  const SharedScene& shared_;
  TextureMappingSettings settings_;
  const gl::Context& context_;
  MappedScene mapped_;
  gl::VertexArray film_;
  std::vector<std::unique_ptr<gl::Program>> programs_;
  std::vector<std::vector<std::unique_ptr<Texture2D>>> textures_;
};

}  // namespace

std::unique_ptr<PreparedTechnique> prepare_subsurface_texture_gl(const SharedScene& shared, const Settings& settings,
                                                                 const gl::Context& context) {
  return std::make_unique<GlMapping>(shared, read_texture_mapping_settings(settings), context);
}

}  // namespace opaline
