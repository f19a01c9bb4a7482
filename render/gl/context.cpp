#include "render/gl/context.h"

#include "model/check.h"
#include "render/gl/platform.h"
#include "render/input_error.h"

#include <dlfcn.h>
#include <glad/gl.h>

#include <algorithm>
#include <cctype>

namespace opaline::gl {
namespace {

thread_local Platform* current = nullptr;

/// One library must be released before another one's context can be made current.
bool make_current(Platform& platform) {
  if (current == &platform) return true;
  if (current) current->release();
  current = platform.make_current() ? &platform : nullptr;
  return current != nullptr;
}

void release(Platform& platform) {
  if (current != &platform) return;
  platform.release();
  current = nullptr;
}

GLADapiproc load_function(void* platform, const char* name) {
  return static_cast<const Platform*>(platform)->function(name);
}

std::string text(const GladGLContext& gl, GLenum name) {
  const GLubyte* value = gl.GetString(name);
  return value ? reinterpret_cast<const char*>(value) : "";
}

bool names_software(std::string renderer) {
  std::transform(renderer.begin(), renderer.end(), renderer.begin(), [](unsigned char c) { return std::tolower(c); });
  for (const char* name : {"llvmpipe", "softpipe", "swrast", "software", "swr"})
    if (renderer.find(name) != std::string::npos) return true;
  return false;
}

}  // namespace

void* open_library(const std::string& name, std::string& reason) {
  void* handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!handle) reason = dlerror();
  return handle;
}

Platform::Function library_function(void* library, const char* name) {
  return reinterpret_cast<Platform::Function>(dlsym(library, name));
}

Api parse_api(const std::string& word) {
  if (word.empty()) return Api::any;
  if (word == "egl") return Api::egl;
  if (word == "osmesa") return Api::osmesa;
  throw InputError("--gl", "", "'" + word + "' is not one of egl, osmesa");
}

std::string ContextInfo::description() const {
  return renderer + (software ? ", software renderer, " : ", ") + platform + ", OpenGL " + version;
}

std::unique_ptr<Context> Context::create(Api api, const Libraries& libraries) {
  std::string tried, reason;
  const auto failed = [&](const std::string& name) { tried += (tried.empty() ? "" : "; ") + name + ": " + reason; };
  const auto take = [](std::unique_ptr<Platform> platform) {
    return std::unique_ptr<Context>(new Context(std::move(platform)));
  };
  if (api != Api::osmesa) {
    for (auto& platform : make_egl_devices(libraries.egl, reason)) {
      auto context = take(std::move(platform));
      if (context->functions_ && !context->info_.software) return context;
      reason = "no hardware device";
    }
    failed("EGL device");
  }
  if (api != Api::egl) {
    if (auto platform = make_osmesa(libraries.osmesa, reason))
      if (auto context = take(std::move(platform)); context->functions_) return context;
    failed("OSMesa");
  }
  if (api != Api::osmesa) {
    if (auto platform = make_egl_surfaceless(libraries.egl, reason))
      if (auto context = take(std::move(platform)); context->functions_) return context;
    failed("EGL surfaceless");
  }
  throw MachineError("no OpenGL 4.3 on this machine (" + tried +
                     "). Use --backend cpu, or install a driver (Debian's software renderer: libosmesa6, or libegl1 "
                     "with libgl1-mesa-dri)");
}

Context::Context(std::unique_ptr<Platform> platform) : platform_(std::move(platform)) {
  if (!make_current(*platform_)) return;
  auto functions = std::make_unique<GladGLContext>();
  const int version = gladLoadGLContextUserPtr(functions.get(), load_function, platform_.get());
  if (version < GLAD_MAKE_VERSION(4, 3)) return;
  functions_ = std::move(functions);
  info_ = {platform_->name(), text(*functions_, GL_RENDERER), text(*functions_, GL_VERSION), false};
  info_.software = names_software(info_.renderer);
}

Context::~Context() { release(*platform_); }

const GladGLContext& Context::use() const {
  OPALINE_CHECK(make_current(*platform_));
  return *functions_;
}

void Context::finish() const { use().Finish(); }

void Context::check_errors() const {
  const GLenum error = use().GetError();
  if (error == GL_OUT_OF_MEMORY) throw MachineError("the GL device is out of memory: " + info_.description());
  OPALINE_CHECK(error == GL_NO_ERROR);
}

}  // namespace opaline::gl
