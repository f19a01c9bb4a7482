// How a context comes to be: one class per library.
#pragma once

#include "render/gl/context.h"

#include <string>
#include <vector>

namespace opaline::gl {

/// A core context of GL 4.3 or later. The libraries stay open: their drivers keep threads and thread-local data.
class Platform {
 public:
  virtual ~Platform() = default;
  virtual const char* name() const = 0;
  virtual bool make_current() = 0;
  virtual void release() = 0;
  using Function = void (*)();
  virtual Function function(const char* name) const = 0;
};

/// The context of that platform, or null and the reason.
std::unique_ptr<Platform> make_osmesa(const std::string& library, std::string& reason);
std::unique_ptr<Platform> make_egl_surfaceless(const std::string& library, std::string& reason);
/// Contexts of the EGL devices that don't call themselves software, as they come.
std::vector<std::unique_ptr<Platform>> make_egl_devices(const std::string& library, std::string& reason);

/// A library opened for good; null and the reason if it cannot be.
void* open_library(const std::string& name, std::string& reason);
/// Address of a function in it, or null.
Platform::Function library_function(void* library, const char* name);

}  // namespace opaline::gl
