#include "render/gl/platform.h"

#include <array>

namespace opaline::gl {
namespace {

// The few names of GL/osmesa.h that are needed.
using OSMesaContext = struct osmesa_context*;
constexpr int osmesa_format = 0x22, osmesa_depth_bits = 0x30, osmesa_profile = 0x33, osmesa_core_profile = 0x34,
              osmesa_major = 0x36, osmesa_minor = 0x37;
constexpr int rgba = 0x1908, unsigned_byte = 0x1401;

struct OSMesaFunctions {
  OSMesaContext (*create)(const int* attributes, OSMesaContext share) = nullptr;
  void (*destroy)(OSMesaContext) = nullptr;
  unsigned char (*make_current)(OSMesaContext, void* buffer, unsigned type, int width, int height) = nullptr;
  Platform::Function (*get_function)(const char*) = nullptr;

  bool load(void* library) {
    create = reinterpret_cast<decltype(create)>(library_function(library, "OSMesaCreateContextAttribs"));
    destroy = reinterpret_cast<decltype(destroy)>(library_function(library, "OSMesaDestroyContext"));
    make_current = reinterpret_cast<decltype(make_current)>(library_function(library, "OSMesaMakeCurrent"));
    get_function = reinterpret_cast<decltype(get_function)>(library_function(library, "OSMesaGetProcAddress"));
    return create && destroy && make_current && get_function;
  }
};

class OSMesaPlatform : public Platform {
 public:
  OSMesaPlatform(const OSMesaFunctions& f, OSMesaContext context) : f_(f), context_(context) {}
  ~OSMesaPlatform() override { f_.destroy(context_); }
  const char* name() const override { return "OSMesa"; }
  bool make_current() override { return f_.make_current(context_, buffer_.data(), unsigned_byte, side, side) != 0; }
  void release() override { f_.make_current(nullptr, nullptr, 0, 0, 0); }
  Function function(const char* name) const override { return f_.get_function(name); }

 private:
  static constexpr int side = 16;  // the default framebuffer nobody draws to
  OSMesaFunctions f_;
  OSMesaContext context_;
  std::array<unsigned char, 4 * side * side> buffer_{};
};

}  // namespace

std::unique_ptr<Platform> make_osmesa(const std::string& library, std::string& reason) {
  void* handle = open_library(library, reason);
  if (!handle) return nullptr;
  OSMesaFunctions f;
  if (!f.load(handle)) {
    reason = library + " lacks OSMesaCreateContextAttribs";
    return nullptr;
  }
  const int attributes[] = {osmesa_format,
                            rgba,
                            osmesa_depth_bits,
                            24,
                            osmesa_profile,
                            osmesa_core_profile,
                            osmesa_major,
                            4,
                            osmesa_minor,
                            3,
                            0,
                            0};
  OSMesaContext context = f.create(attributes, nullptr);
  if (!context) {
    reason = library + " makes no GL 4.3 core context";
    return nullptr;
  }
  return std::make_unique<OSMesaPlatform>(f, context);
}

}  // namespace opaline::gl
