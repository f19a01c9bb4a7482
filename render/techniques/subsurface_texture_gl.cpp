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

/// What march.glsl wants to be given: its words in GLSL, and the scene's sizes and uniforms.
std::string given_source(const MarchMedium& medium, std::size_t lights, const MarchSettings& march, bool reflection) {
  constexpr const char* words = R"(
#define Real float
#define Real2 vec2
#define Real3 vec3
#define Mask bool
#define Bits int
#define FORMULA
#define IN(type) type
#define INOUT(type) inout type
const int most_layers = layers, most_lights = lights;
uniform vec3 light_place[lights], light_power[lights];
uniform float light_far[lights];
uniform vec3 sigma_s[layers + 1], sigma_t[layers + 1];
uniform vec4 phase_of[layers + 1];
uniform float largest_depth, negligible;
struct Depths {
  float of[layers];
};
struct FarSide {
  vec3 normal;
  float height;
  vec2 uv;
};
uniform sampler2D far_sides;  // blocks as large as the film: of each light the normal and height, then uv
const int across = min(2 * lights, 8), down = (2 * lights + across - 1) / across;
vec4 far_texel(int block) {
  ivec2 size = textureSize(far_sides, 0) / ivec2(across, down);
  return texelFetch(far_sides, ivec2(gl_FragCoord.xy) + size * ivec2(block % across, block / across), 0);
}
FarSide far_side(int l) {
  vec4 plane = far_texel(2 * l);
  return FarSide(plane.xyz, plane.w, far_texel(2 * l + 1).xy);
}
float exit_cosine() { return far_texel(1).z; }
bool sees(int bits, int l) { return (bits >> l & 1) != 0; }
bool sees_any(int bits) { return bits != 0; }
bool some(bool m) { return m; }
float choose(bool m, float a, float b) { return m ? a : b; }
vec2 choose(bool m, vec2 a, vec2 b) { return m ? a : b; }
vec3 choose(bool m, vec3 a, vec3 b) { return m ? a : b; }
vec3 exp_minus(vec3 x) { return exp(-x); }
float inverse_root(float x) { return inversesqrt(x); }
)";
  return fmt::format(
             "const int layers = {}, lights = {}, samples = {};\nconst bool by_pieces = {}, reflection = {};\n"
             "const float least_view_cosine = {};\n",
             medium.stack.count, lights, march.samples, march.by_pieces, reflection, least_view_cosine) +
         words;
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
                          medium.source->depth_scale);
      have = texture;
    }
    read += fmt::format("  d.of[{}] = max({}, t{}.{});\n", i, i == 0 ? "0.0" : fmt::format("d.of[{}]", i - 1), texture,
                        names[static_cast<std::size_t>(k % 4)]);
  }
  return text + "Depths boundaries(vec2 uv) {\n  Depths d;\n" + read + "  return d;\n}\n";
}

/// The points of an object, a texel each, field by field.
struct PointImages {
  int height = 0, across = 0, down = 0;  ///< the last field has so many blocks of the others' size
  std::vector<float> fields[7];

  PointImages(std::size_t points, std::size_t lights)
      : height(static_cast<int>((points + row - 1) / row)),
        across(std::min(2 * static_cast<int>(lights), 8)),
        down((2 * static_cast<int>(lights) + across - 1) / across) {
    for (std::vector<float>& f : fields) f.assign(4 * static_cast<std::size_t>(row * height), 0.0f);
    fields[6].assign(fields[0].size() * static_cast<std::size_t>(across * down), 0.0f);
  }
  /// Texel i of a block of the last field.
  float* far_texel(std::size_t block, std::size_t i) {
    const auto wide = static_cast<std::size_t>(across), high = static_cast<std::size_t>(height),
               line = std::size_t{row};
    const std::size_t x = i % line + block % wide * line, y = i / line + block / wide * high;
    return &fields[6][4 * (y * wide * line + x)];
  }
  void put(std::size_t i, const MarchPoint& p) {
    const auto texel = [&](int field, const glm::vec3& v, float w) {
      std::copy_n(&v.x, 3, &fields[field][4 * i]);
      fields[field][4 * i + 3] = w;
    };
    texel(0, p.position, p.exit), texel(1, p.normal, p.plane_height), texel(2, p.plane_normal, p.uv.x);
    texel(3, p.gradient_u, p.uv.y), texel(4, p.gradient_v, static_cast<float>(p.lights));
    texel(5, p.w_o, static_cast<float>(p.visible));
    for (std::size_t l = 0; l < p.far.size(); ++l) {
      const FarSide& side = p.far[l];
      float *plane = far_texel(2 * l, i), *uv = far_texel(2 * l + 1, i);
      std::copy_n(&side.normal.x, 3, plane);
      plane[3] = side.height, uv[0] = side.uv.x, uv[1] = side.uv.y;
    }
    far_texel(1, i)[2] = p.exit_cosine;
  }
};

constexpr const char* field_names[7] = {"positions",   "normals", "plane_normals", "gradients_u",
                                        "gradients_v", "views",   "far_sides"};

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
      for (const SurfaceTexture& texture : object->medium.source->depths)
        textures_.back().push_back(depth_texture(context, texture));
    }
  }

  Frame render(const GBuffer& view) const override {
    Frame frame;
    frame.radiance.assign(view.points.size(), glm::vec3(0));
    frame.counters = mapped_.counters;
    for (std::size_t o = 0; o < mapped_.objects.size(); ++o) {
      const ObjectPoints points = points_of_object(view, static_cast<int>(o));
      if (!points.indices.empty()) render_object(o, view, points.indices, frame);
    }
    return frame;
  }

 private:
  /// Arrays have room for one light at least; no point sees it where there is none.
  std::size_t program_lights() const { return std::max<std::size_t>(1, mapped_.lights.size()); }

  std::unique_ptr<gl::Program> make_program(const MappedObject& object) const {
    const std::string given = given_source(object.medium, program_lights(), settings_.march, settings_.reflection);
    return std::make_unique<gl::Program>(
        context_, std::vector<gl::Stage>{{gl::StageKind::vertex, {gl::shader_file("render/gl/fullscreen.vert")}},
                                         {gl::StageKind::fragment,
                                          {{"given", given},
                                           {"boundaries", boundaries_source(object.medium)},
                                           gl::shader_file("render/subsurface/march.glsl"),
                                           gl::shader_file("render/techniques/subsurface_texture.frag")}}});
  }

  void render_object(std::size_t o, const GBuffer& view, const std::vector<std::uint32_t>& indices,
                     Frame& frame) const {
    PointImages images(indices.size(), program_lights());
    std::vector<MarchPoint> points(indices.size());
    std::vector<MarchCounts> rays(indices.size());
    tbb::parallel_for(std::size_t{0}, indices.size(), [&](std::size_t i) {
      points[i] = mapped_.point(shared_, view.points[indices[i]], rays[i]);
      images.put(i, points[i]);
    });
    const Texture2D radiance(context_, row, images.height, Format::rgba32f),
        steps(context_, row, images.height, Format::rgba32f);
    draw(o, images, {&radiance, &steps});
    const std::vector<float> light = radiance.read(), made = steps.read();
    MarchCounts counts;
    for (std::size_t i = 0; i < indices.size(); ++i) {
      const float *l = &light[4 * i], *c = &made[4 * i];
      frame.radiance[indices[i]] = {l[0], l[1], l[2]};
      counts.add(points[i], {{}, c[0], c[1], c[2], c[3]}, settings_.march.samples, mapped_.lights.size());
      counts += rays[i];
    }
    frame.counters += MappedScene::named(counts, *mapped_.objects[o]);
  }

  void draw(std::size_t o, const PointImages& images, const std::array<const Texture2D*, 2>& targets) const {
    const gl::Program& program = *programs_[o];
    std::vector<std::unique_ptr<Texture2D>> fields;
    for (const std::vector<float>& field : images.fields) {
      const bool last = &field == &images.fields[6];
      fields.push_back(std::make_unique<Texture2D>(context_, last ? row * images.across : row,
                                                   last ? images.height * images.down : images.height, Format::rgba32f,
                                                   field.data()));
    }
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
    const MediumLayers& stack = object.medium.stack;
    for (std::size_t k = 0; k <= static_cast<std::size_t>(stack.count); ++k) {
      set("sigma_s", k, stack.sigma_s[k]);
      set("sigma_t", k, stack.sigma_t[k]);
      set("phase_of", k, object.medium.phases[k]);
    }
    for (std::size_t l = 0; l < mapped_.lights.size(); ++l) {
      set("light_place", l, mapped_.lights[l].place);
      set("light_power", l, mapped_.lights[l].power);
      set("light_far", l, mapped_.lights[l].far ? 1.0f : 0.0f);
    }
    program.set("largest_depth", object.medium.largest_depth);
    program.set("negligible", settings_.march.negligible);
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
