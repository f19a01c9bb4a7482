// The GL layer: contexts of both libraries, programs, buffers, textures, framebuffers, and what goes wrong.
#include "render/gl/context.h"
#include "render/gl/program.h"
#include "render/gl/resources.h"
#include "render/input_error.h"
#include "tests/support/gl_fixture.h"

#include <gmock/gmock.h>

#include <numeric>

namespace opaline::gl {
namespace {

using testing::HasSubstr;

const ShaderText square_comp{"square.comp",
                             "layout(local_size_x = 16) in;\n"
                             "layout(std430, binding = 0) buffer Values { float values[]; };\n"
                             "void main() { uint i = gl_GlobalInvocationID.x; values[i] *= values[i]; }\n"};

const ShaderText plain_vert{"plain.vert",
                            "layout(location = 0) in vec3 position;\n"
                            "void main() { gl_Position = vec4(position, 1); }\n"};

const ShaderText colour_frag{"colour.frag",
                             "layout(location = 0) out vec4 colour;\n"
                             "uniform vec4 value;\n"
                             "void main() { colour = value; }\n"};

void expect_squares(const Context& context) {
  std::vector<float> numbers(64);
  std::iota(numbers.begin(), numbers.end(), 1.0f);
  const Program program(context, {{StageKind::compute, {square_comp}}});
  const Buffer buffer(context, numbers);
  buffer.bind_storage(0);
  program.dispatch(4);
  const std::vector<float> squares = buffer.read<float>();
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(squares[i], numbers[i] * numbers[i]);
}

/// Draws a triangle over the lower left half of 8 x 8 pixels.
std::vector<float> half_square(const Context& context, const glm::vec4& value) {
  const Program program(context, {{StageKind::vertex, {plain_vert}}, {StageKind::fragment, {colour_frag}}});
  const Buffer corners(context, std::vector<glm::vec3>{{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}});
  const Buffer* attributes[] = {&corners};
  const VertexArray triangle(context, attributes);
  const Texture2D image(context, 8, 8, Format::rgba32f);
  const Texture2D* colours[] = {&image};
  const Framebuffer target(context, colours);
  target.clear();
  program.set("value", value);
  target.bind();
  program.use();
  triangle.draw_triangles(3);
  return image.read();
}

void expect_triangle(const Context& context) {
  const std::vector<float> pixels = half_square(context, {1000.5f, 2, 3, 4});
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) {
      if (x + y == 7) continue;  // on the diagonal
      const float* p = &pixels[static_cast<std::size_t>(4 * (8 * y + x))];
      EXPECT_EQ(p[0], x + y < 7 ? 1000.5f : 0.0f) << x << " " << y;
      EXPECT_EQ(p[3], x + y < 7 ? 4.0f : 0.0f);
    }
}

class EachLibrary : public testing::TestWithParam<Api> {
 protected:
  std::unique_ptr<Context> context_;
  void SetUp() override { context_ = test::context_or_null(GetParam()); }
};

TEST_P(EachLibrary, NamesItsRenderer) {
  if (!context_) GTEST_SKIP() << test::no_gl;
  EXPECT_FALSE(context_->info().renderer.empty());
  EXPECT_THAT(context_->info().platform, HasSubstr(GetParam() == Api::egl ? "EGL" : "OSMesa"));
  EXPECT_EQ(context_->info().software, context_->info().description().find("software renderer") != std::string::npos);
  EXPECT_TRUE(context_->info().software || context_->info().renderer.find("llvmpipe") == std::string::npos);
}

TEST_P(EachLibrary, RunsAComputeShader) {
  if (!context_) GTEST_SKIP() << test::no_gl;
  expect_squares(*context_);
}

TEST_P(EachLibrary, DrawsATriangle) {
  if (!context_) GTEST_SKIP() << test::no_gl;
  expect_triangle(*context_);
}

TEST_P(EachLibrary, TimesWorkThatHasEnded) {
  if (!context_) GTEST_SKIP() << test::no_gl;
  EXPECT_GT(timed(*context_, [&] { expect_squares(*context_); }), 0);
}

INSTANTIATE_TEST_SUITE_P(Gl, EachLibrary, testing::Values(Api::egl, Api::osmesa),
                         [](const auto& row) { return row.param == Api::egl ? "egl" : "osmesa"; });

TEST(Gl, BothLibrariesWorkSideBySide) {
  const auto egl = test::context_or_null(Api::egl), osmesa = test::context_or_null(Api::osmesa);
  if (!egl || !osmesa) GTEST_SKIP() << test::no_gl;
  const Program on_egl(*egl, {{StageKind::compute, {square_comp}}}),
      on_osmesa(*osmesa, {{StageKind::compute, {square_comp}}});
  const Buffer a(*egl, std::vector<float>(16, 3.0f)), b(*osmesa, std::vector<float>(16, 5.0f));
  for (int i = 0; i < 2; ++i) {
    a.bind_storage(0);
    on_egl.dispatch(1);
    b.bind_storage(0);
    on_osmesa.dispatch(1);
  }
  EXPECT_EQ(a.read<float>(), std::vector<float>(16, 81.0f));
  EXPECT_EQ(b.read<float>(), std::vector<float>(16, 625.0f));
  expect_triangle(*egl);
  expect_triangle(*osmesa);
}

TEST(Gl, TexturesKeepFloatsAndInterpolateRows) {
  const auto context = test::context_or_null(Api::any);
  if (!context) GTEST_SKIP() << test::no_gl;
  const std::vector<float> texels = {1, 2, 3, 1e-20f, -5, 1e20f};
  EXPECT_EQ(Texture2D(*context, 3, 2, Format::r32f, texels.data()).read(), texels);
  const ShaderText comp{"row.comp",
                        "layout(local_size_x = 1) in;\n"
                        "layout(binding = 0) uniform sampler1D row;\n"
                        "layout(std430, binding = 0) buffer Out { vec4 value; };\n"
                        "void main() { value = textureLod(row, 0.5, 0); }\n"};
  const Program program(*context, {{StageKind::compute, {comp}}});
  const Texture1D row(*context, {1, 0, 0, 0, 3, 0, 0, 8});
  const Buffer out(*context, std::vector<float>(4));
  row.bind(0);
  out.bind_storage(0);
  program.dispatch(1);
  EXPECT_EQ(out.read<float>(), (std::vector<float>{2, 0, 0, 4}));
}

TEST(Gl, DepthTestKeepsTheNearest) {
  const auto context = test::context_or_null(Api::any);
  if (!context) GTEST_SKIP() << test::no_gl;
  const Program program(*context, {{StageKind::vertex, {plain_vert}}, {StageKind::fragment, {colour_frag}}});
  const Buffer near_far(
      *context, std::vector<glm::vec3>{
                    {-1, -1, -0.5f}, {3, -1, -0.5f}, {-1, 3, -0.5f}, {-1, -1, 0.5f}, {3, -1, 0.5f}, {-1, 3, 0.5f}});
  const Buffer first(*context, std::vector<std::uint32_t>{0, 1, 2}),
      second(*context, std::vector<std::uint32_t>{3, 4, 5});
  const Buffer* attributes[] = {&near_far};
  const VertexArray near(*context, attributes, &first), far(*context, attributes, &second);
  const Texture2D image(*context, 4, 4, Format::r32f), depth(*context, 4, 4, Format::depth32f);
  const Texture2D* colours[] = {&image};
  const Framebuffer target(*context, colours, &depth);
  target.clear(-1);
  program.set("value", glm::vec4(1));
  target.bind();
  program.use();
  near.draw_indexed(1);
  program.set("value", glm::vec4(2));
  far.draw_indexed(1);
  EXPECT_EQ(image.read(), std::vector<float>(16, 1.0f));
  EXPECT_EQ(depth.read(), std::vector<float>(16, 0.25f));
}

TEST(Gl, ShaderErrorsNameFileAndLine) {
  const auto context = test::context_or_null(Api::any);
  if (!context) GTEST_SKIP() << test::no_gl;
  const ShaderText shared{"shared.glsl", "float twice(float x) { return 2 * x; }\n"};
  const ShaderText broken{"broken.comp", "layout(local_size_x = 1) in;\n\nvoid main() { twice(nothing); }\n"};
  try {
    const Program program(*context, {{StageKind::compute, {shared, broken}}});
    FAIL() << "compiled";
  } catch (const ShaderError& error) {
    EXPECT_THAT(error.what(), HasSubstr("broken.comp:3:"));
    EXPECT_THAT(error.what(), HasSubstr("nothing"));
  }
}

TEST(Gl, ReadableLogUnderstandsSeveralDrivers) {
  const std::vector<ShaderText> texts = {{"a.glsl", ""}, {"b.frag", ""}};
  EXPECT_EQ(readable_log("0:100012(5): error: no", texts), "b.frag:12: error: no");
  EXPECT_EQ(readable_log("0(7) : error C1008: no", texts), "a.glsl:7: error C1008: no");
  EXPECT_EQ(readable_log("ERROR: 0:100003: 'x' : undeclared", texts), "b.frag:3: 'x' : undeclared");
  EXPECT_EQ(readable_log("something else", texts), "something else");
}

TEST(Gl, AMachineWithoutItSaysSo) {
  try {
    Context::create(Api::any, {"libno-egl.so.1", "libno-osmesa.so.8"});
    FAIL() << "a context of nothing";
  } catch (const MachineError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no OpenGL 4.3 on this machine"));
    EXPECT_THAT(error.what(), HasSubstr("libno-egl.so.1"));
    EXPECT_THAT(error.what(), HasSubstr("libno-osmesa.so.8"));
    EXPECT_THAT(error.what(), HasSubstr("--backend cpu"));
  }
}

TEST(Gl, UnknownLibrariesAreAnError) {
  EXPECT_EQ(parse_api(""), Api::any);
  EXPECT_EQ(parse_api("osmesa"), Api::osmesa);
  EXPECT_THROW(parse_api("vulkan"), InputError);
}

}  // namespace
}  // namespace opaline::gl
