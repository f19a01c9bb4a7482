// Buffers, textures, framebuffers and vertex arrays that free themselves. All belong to one context, which must
// outlive them; every call makes it current.
#pragma once

#include "render/gl/context.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace opaline::gl {

/// A storage buffer of fixed size.
class Buffer {
 public:
  Buffer(const Context& context, std::size_t bytes, const void* data = nullptr);
  template <typename T>
  Buffer(const Context& context, const std::vector<T>& values)
      : Buffer(context, values.size() * sizeof(T), values.data()) {}
  ~Buffer();
  Buffer(const Buffer&) = delete;
  Buffer& operator=(const Buffer&) = delete;

  void bind_storage(unsigned binding) const;
  unsigned id() const { return id_; }
  std::size_t bytes() const { return bytes_; }
  template <typename T>
  std::vector<T> read() const {
    std::vector<T> values(bytes_ / sizeof(T));
    read_bytes(values.data());
    return values;
  }

 private:
  void read_bytes(void* out) const;
  const Context& context_;
  unsigned id_ = 0;
  std::size_t bytes_;
};

enum class Format { r32f, rgba32f, depth32f };

/// Number of floats a texel has.
int channels_of(Format format);

/// What a sampler finds between texel centres.
enum class Sampling { nearest, linear };
/// What a sampler finds outside.
enum class Wrap { clamp, repeat, mirror };

/// A two-dimensional float texture. A depth texture compares (sampler2DShadow).
class Texture2D {
 public:
  Texture2D(const Context& context, int width, int height, Format format, const float* data = nullptr,
            Sampling sampling = Sampling::nearest, Wrap wrap = Wrap::clamp);
  ~Texture2D();
  Texture2D(const Texture2D&) = delete;
  Texture2D& operator=(const Texture2D&) = delete;

  void bind(unsigned unit) const;
  /// Row by row from the one at t = 0.
  std::vector<float> read() const;
  void write(const float* data) const;
  int width() const { return width_; }
  int height() const { return height_; }
  Format format() const { return format_; }
  unsigned id() const { return id_; }

 private:
  const Context& context_;
  unsigned id_ = 0;
  int width_, height_;
  Format format_;
};

/// A row of RGBA texels, interpolated linearly, clamped to its ends.
class Texture1D {
 public:
  Texture1D(const Context& context, const std::vector<float>& rgba);
  ~Texture1D();
  Texture1D(const Texture1D&) = delete;
  Texture1D& operator=(const Texture1D&) = delete;
  void bind(unsigned unit) const;

 private:
  const Context& context_;
  unsigned id_ = 0;
};

/// What is drawn to: colour textures in order, perhaps a depth texture. The textures must outlive it.
class Framebuffer {
 public:
  Framebuffer(const Context& context, std::span<const Texture2D* const> colours, const Texture2D* depth = nullptr);
  ~Framebuffer();
  Framebuffer(const Framebuffer&) = delete;
  Framebuffer& operator=(const Framebuffer&) = delete;

  /// Draws go here, to all of it; depth test on if there is a depth texture.
  void bind() const;
  /// Every colour to `value` in all channels, depth to 1.
  void clear(float value = 0) const;

 private:
  const Context& context_;
  unsigned id_ = 0;
  int width_ = 0, height_ = 0, colours_ = 0;
  bool depth_ = false;
};

/// Vertices: attributes 0, 1, ... of three floats each, one buffer per attribute, and triangles.
class VertexArray {
 public:
  VertexArray(const Context& context, std::span<const Buffer* const> attributes, const Buffer* triangles = nullptr);
  ~VertexArray();
  VertexArray(const VertexArray&) = delete;
  VertexArray& operator=(const VertexArray&) = delete;

  void draw_triangles(std::size_t vertices) const;  ///< as they stand; works without any attribute
  void draw_indexed(std::size_t triangles) const;

 private:
  const Context& context_;
  unsigned id_ = 0;
};

}  // namespace opaline::gl
