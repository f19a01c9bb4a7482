#include "render/gl/resources.h"

#include "model/check.h"

#include <glad/gl.h>

namespace opaline::gl {
namespace {

struct PixelLayout {
  GLenum internal, format;
};

PixelLayout layout_of(Format format) {
  switch (format) {
    case Format::r32f:
      return {GL_R32F, GL_RED};
    case Format::rgba32f:
      return {GL_RGBA32F, GL_RGBA};
    default:
      return {GL_DEPTH_COMPONENT32F, GL_DEPTH_COMPONENT};
  }
}

GLint wrap_mode(Wrap wrap) {
  return wrap == Wrap::repeat ? GL_REPEAT : wrap == Wrap::mirror ? GL_MIRRORED_REPEAT : GL_CLAMP_TO_EDGE;
}

void set_sampling(const GladGLContext& gl, GLenum target, GLint filter, Wrap wrap = Wrap::clamp) {
  gl.TexParameteri(target, GL_TEXTURE_MIN_FILTER, filter);
  gl.TexParameteri(target, GL_TEXTURE_MAG_FILTER, filter);
  gl.TexParameteri(target, GL_TEXTURE_WRAP_S, wrap_mode(wrap));
  gl.TexParameteri(target, GL_TEXTURE_WRAP_T, wrap_mode(wrap));
}

}  // namespace

int channels_of(Format format) { return format == Format::rgba32f ? 4 : 1; }

Buffer::Buffer(const Context& context, std::size_t bytes, const void* data) : context_(context), bytes_(bytes) {
  const GladGLContext& gl = context.use();
  gl.GenBuffers(1, &id_);
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  // A buffer of no bytes cannot be bound.
  gl.BufferData(GL_SHADER_STORAGE_BUFFER, static_cast<GLsizeiptr>(std::max<std::size_t>(bytes, 16)), nullptr,
                GL_DYNAMIC_COPY);
  if (data && bytes > 0) gl.BufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes), data);
  context.check_errors();
}

Buffer::~Buffer() { context_.use().DeleteBuffers(1, &id_); }

void Buffer::bind_storage(unsigned binding) const {
  context_.use().BindBufferBase(GL_SHADER_STORAGE_BUFFER, binding, id_);
}

void Buffer::read_bytes(void* out) const {
  const GladGLContext& gl = context_.use();
  gl.BindBuffer(GL_SHADER_STORAGE_BUFFER, id_);
  gl.GetBufferSubData(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizeiptr>(bytes_), out);
  context_.check_errors();
}

Texture2D::Texture2D(const Context& context, int width, int height, Format format, const float* data, Sampling sampling,
                     Wrap wrap)
    : context_(context), width_(width), height_(height), format_(format) {
  const GladGLContext& gl = context.use();
  gl.GenTextures(1, &id_);
  gl.BindTexture(GL_TEXTURE_2D, id_);
  gl.TexStorage2D(GL_TEXTURE_2D, 1, layout_of(format).internal, width, height);
  set_sampling(gl, GL_TEXTURE_2D, sampling == Sampling::linear ? GL_LINEAR : GL_NEAREST, wrap);
  if (format == Format::depth32f) {
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
  }
  if (data) write(data);
  context.check_errors();
}

Texture2D::~Texture2D() { context_.use().DeleteTextures(1, &id_); }

void Texture2D::bind(unsigned unit) const {
  const GladGLContext& gl = context_.use();
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D, id_);
}

void Texture2D::write(const float* data) const {
  const GladGLContext& gl = context_.use();
  gl.BindTexture(GL_TEXTURE_2D, id_);
  gl.TexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, width_, height_, layout_of(format_).format, GL_FLOAT, data);
}

std::vector<float> Texture2D::read() const {
  const GladGLContext& gl = context_.use();
  std::vector<float> values(static_cast<std::size_t>(width_ * height_ * channels_of(format_)));
  gl.BindTexture(GL_TEXTURE_2D, id_);
  gl.GetTexImage(GL_TEXTURE_2D, 0, layout_of(format_).format, GL_FLOAT, values.data());
  context_.check_errors();
  return values;
}

Texture1D::Texture1D(const Context& context, const std::vector<float>& rgba) : context_(context) {
  const GladGLContext& gl = context.use();
  const auto texels = static_cast<GLsizei>(rgba.size() / 4);
  gl.GenTextures(1, &id_);
  gl.BindTexture(GL_TEXTURE_1D, id_);
  gl.TexStorage1D(GL_TEXTURE_1D, 1, GL_RGBA32F, texels);
  gl.TexSubImage1D(GL_TEXTURE_1D, 0, 0, texels, GL_RGBA, GL_FLOAT, rgba.data());
  set_sampling(gl, GL_TEXTURE_1D, GL_LINEAR);
  context.check_errors();
}

Texture1D::~Texture1D() { context_.use().DeleteTextures(1, &id_); }

void Texture1D::bind(unsigned unit) const {
  const GladGLContext& gl = context_.use();
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_1D, id_);
}

Framebuffer::Framebuffer(const Context& context, std::span<const Texture2D* const> colours, const Texture2D* depth)
    : context_(context), colours_(static_cast<int>(colours.size())), depth_(depth != nullptr) {
  const GladGLContext& gl = context.use();
  const Texture2D* first = colours.empty() ? depth : colours.front();
  OPALINE_CHECK(first);
  width_ = first->width(), height_ = first->height();
  gl.GenFramebuffers(1, &id_);
  gl.BindFramebuffer(GL_FRAMEBUFFER, id_);
  std::vector<GLenum> targets;
  for (const Texture2D* colour : colours) {
    targets.push_back(GL_COLOR_ATTACHMENT0 + static_cast<GLenum>(targets.size()));
    gl.FramebufferTexture(GL_FRAMEBUFFER, targets.back(), colour->id(), 0);
  }
  if (depth) gl.FramebufferTexture(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, depth->id(), 0);
  if (targets.empty()) targets.push_back(GL_NONE);
  gl.DrawBuffers(static_cast<GLsizei>(targets.size()), targets.data());
  OPALINE_CHECK(gl.CheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
}

Framebuffer::~Framebuffer() { context_.use().DeleteFramebuffers(1, &id_); }

void Framebuffer::bind() const {
  const GladGLContext& gl = context_.use();
  gl.BindFramebuffer(GL_FRAMEBUFFER, id_);
  gl.Viewport(0, 0, width_, height_);
  (depth_ ? gl.Enable : gl.Disable)(GL_DEPTH_TEST);
}

void Framebuffer::clear(float value) const {
  bind();
  const GladGLContext& gl = context_.use();
  const float colour[4] = {value, value, value, value}, far = 1;
  for (int i = 0; i < colours_; ++i) gl.ClearBufferfv(GL_COLOR, i, colour);
  if (depth_) gl.ClearBufferfv(GL_DEPTH, 0, &far);
}

VertexArray::VertexArray(const Context& context, std::span<const Buffer* const> attributes, const Buffer* triangles)
    : context_(context) {
  const GladGLContext& gl = context.use();
  gl.GenVertexArrays(1, &id_);
  gl.BindVertexArray(id_);
  for (std::size_t i = 0; i < attributes.size(); ++i) {
    gl.BindBuffer(GL_ARRAY_BUFFER, attributes[i]->id());
    gl.VertexAttribPointer(static_cast<GLuint>(i), 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(static_cast<GLuint>(i));
  }
  if (triangles) gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, triangles->id());
  context.check_errors();
}

VertexArray::~VertexArray() { context_.use().DeleteVertexArrays(1, &id_); }

void VertexArray::draw_triangles(std::size_t vertices) const {
  const GladGLContext& gl = context_.use();
  gl.BindVertexArray(id_);
  gl.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(vertices));
}

void VertexArray::draw_indexed(std::size_t triangles) const {
  const GladGLContext& gl = context_.use();
  gl.BindVertexArray(id_);
  gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * triangles), GL_UNSIGNED_INT, nullptr);
}

}  // namespace opaline::gl
