#include "render/gl/platform.h"

#include <cstring>

namespace opaline::gl {
namespace {

// The few names of EGL/egl.h and eglext.h that are needed.
using Display = void*;
using Config = void*;
using EglContext = void*;
using Device = void*;
using Surface = void*;
constexpr int egl_extensions = 0x3055, egl_opengl_api = 0x30A2, egl_surface_type = 0x3033, egl_renderable_type = 0x3040,
              egl_opengl_bit = 8, egl_none = 0x3038, egl_major = 0x3098, egl_minor = 0x30FB, egl_profile_mask = 0x30FD,
              egl_core_bit = 1, egl_platform_device = 0x313F, egl_platform_surfaceless = 0x31DD;

struct Egl {
  Platform::Function (*get_function)(const char*) = nullptr;
  const char* (*query_string)(Display, int) = nullptr;
  unsigned (*initialize)(Display, int*, int*) = nullptr;
  unsigned (*bind_api)(unsigned) = nullptr;
  unsigned (*choose_config)(Display, const int*, Config*, int, int*) = nullptr;
  EglContext (*create_context)(Display, Config, EglContext, const int*) = nullptr;
  unsigned (*destroy_context)(Display, EglContext) = nullptr;
  unsigned (*make_current)(Display, Surface, Surface, EglContext) = nullptr;
  // Extensions; may be missing.
  Display (*get_platform_display)(unsigned, void*, const int*) = nullptr;
  unsigned (*query_devices)(int, Device*, int*) = nullptr;
  const char* (*query_device_string)(Device, int) = nullptr;

  template <typename F>
  bool find(void* library, const char* name, F& f) {
    f = reinterpret_cast<F>(library_function(library, name));
    return f != nullptr;
  }
  template <typename F>
  void find_extension(const char* name, F& f) {
    f = reinterpret_cast<F>(get_function(name));
  }

  /// Empty, or why the library is of no use.
  std::string load(void* library) {
    const bool all =
        find(library, "eglGetProcAddress", get_function) && find(library, "eglQueryString", query_string) &&
        find(library, "eglInitialize", initialize) && find(library, "eglBindAPI", bind_api) &&
        find(library, "eglChooseConfig", choose_config) && find(library, "eglCreateContext", create_context) &&
        find(library, "eglDestroyContext", destroy_context) && find(library, "eglMakeCurrent", make_current);
    if (!all) return "a function of EGL 1.5 is missing";
    find_extension("eglGetPlatformDisplayEXT", get_platform_display);
    find_extension("eglQueryDevicesEXT", query_devices);
    find_extension("eglQueryDeviceStringEXT", query_device_string);
    return get_platform_display ? "" : "eglGetPlatformDisplayEXT is missing";
  }
};

class EglPlatform : public Platform {
 public:
  EglPlatform(const Egl& egl, const char* name, Display display, EglContext context)
      : egl_(egl), name_(name), display_(display), context_(context) {}
  // The display isn't terminated: the library hands the same one to everyone in the process.
  ~EglPlatform() override { egl_.destroy_context(display_, context_); }
  const char* name() const override { return name_; }
  bool make_current() override {
    egl_.bind_api(egl_opengl_api);
    return egl_.make_current(display_, nullptr, nullptr, context_) != 0;
  }
  void release() override { egl_.make_current(display_, nullptr, nullptr, nullptr); }
  Function function(const char* name) const override { return egl_.get_function(name); }

 private:
  Egl egl_;
  const char* name_;
  Display display_;
  EglContext context_;
};

std::unique_ptr<Platform> make_context(const Egl& egl, const char* name, Display display, std::string& reason) {
  if (!display || !egl.initialize(display, nullptr, nullptr)) {
    reason = "no display";
    return nullptr;
  }
  egl.bind_api(egl_opengl_api);
  const int wanted[] = {egl_surface_type, 0, egl_renderable_type, egl_opengl_bit, egl_none};
  Config config = nullptr;
  int count = 0;
  if (!egl.choose_config(display, wanted, &config, 1, &count) || count == 0) config = nullptr;
  const int attributes[] = {egl_major, 4, egl_minor, 3, egl_profile_mask, egl_core_bit, egl_none};
  EglContext context = egl.create_context(display, config, nullptr, attributes);
  if (!context) {
    reason = "no GL 4.3 core context";
    return nullptr;
  }
  return std::make_unique<EglPlatform>(egl, name, display, context);
}

/// EGL of a library, or null functions and the reason.
bool load(const std::string& library, Egl& egl, std::string& reason) {
  void* handle = open_library(library, reason);
  if (!handle) return false;
  const std::string missing = egl.load(handle);
  if (!missing.empty()) reason = library + ": " + missing;
  return missing.empty();
}

}  // namespace

std::unique_ptr<Platform> make_egl_surfaceless(const std::string& library, std::string& reason) {
  Egl egl;
  if (!load(library, egl, reason)) return nullptr;
  return make_context(egl, "EGL surfaceless", egl.get_platform_display(egl_platform_surfaceless, nullptr, nullptr),
                      reason);
}

std::vector<std::unique_ptr<Platform>> make_egl_devices(const std::string& library, std::string& reason) {
  std::vector<std::unique_ptr<Platform>> platforms;
  Egl egl;
  if (!load(library, egl, reason)) return platforms;
  Device devices[16];
  int count = 0;
  if (!egl.query_devices || !egl.query_device_string || !egl.query_devices(16, devices, &count)) count = 0;
  reason = "no hardware device";
  for (int i = 0; i < count; ++i) {
    const char* extensions = egl.query_device_string(devices[i], egl_extensions);
    if (extensions && std::strstr(extensions, "EGL_MESA_device_software")) continue;
    auto platform =
        make_context(egl, "EGL device", egl.get_platform_display(egl_platform_device, devices[i], nullptr), reason);
    if (platform) platforms.push_back(std::move(platform));
  }
  return platforms;
}

}  // namespace opaline::gl
