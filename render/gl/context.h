// An OpenGL 4.3 core context without a window, chosen at run time. Nothing links to a GL library: libraries are opened
// when a context is asked for, and each context has its own table of functions.
//
// Order of choice: an EGL device that is real hardware, then OSMesa, then EGL surfaceless (both software, as a rule).
// A context is current on one thread at a time. Contexts of different libraries may live side by side in a thread:
// whatever is used next is made current, and the other library is released first.
#pragma once

#include "render/stopwatch.h"

#include <memory>
#include <string>
#include <vector>

struct GladGLContext;

namespace opaline::gl {

class Platform;

/// Which libraries may be used.
enum class Api { any, egl, osmesa };

/// Api of the word "egl" or "osmesa"; empty: any. Throws InputError("--gl") otherwise.
Api parse_api(const std::string& word);

/// Names as dlopen takes them.
struct Libraries {
  std::string egl = "libEGL.so.1", osmesa = "libOSMesa.so.8";
};

struct ContextInfo {
  std::string platform;   ///< "EGL device", "OSMesa" or "EGL surfaceless"
  std::string renderer;   ///< GL_RENDERER
  std::string version;    ///< GL_VERSION
  bool software = false;  ///< runs on the processor
  /// "llvmpipe (...), software renderer, OSMesa, 4.5 ..."
  std::string description() const;
};

class Context {
 public:
  /// Throws MachineError, naming what was tried and why it failed, when there is no GL 4.3.
  static std::unique_ptr<Context> create(Api api = Api::any, const Libraries& libraries = {});
  ~Context();
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  const ContextInfo& info() const { return info_; }
  /// Makes the context current on this thread and returns its functions.
  const GladGLContext& use() const;
  /// Waits until all work is done: on a software renderer the only right place for a clock.
  void finish() const;
  /// Throws MachineError if the device ran out of memory, trips a check on any other GL error.
  void check_errors() const;

 private:
  explicit Context(std::unique_ptr<Platform> platform);
  std::unique_ptr<Platform> platform_;
  std::unique_ptr<GladGLContext> functions_;
  ContextInfo info_;
};

/// Wall-clock seconds of GL work, from everything before it done to all of it done. (Timer queries are wrong on
/// software renderers: nothing for compute, up to half too little for draws.)
template <typename Work>
double timed(const Context& context, const Work& work) {
  context.finish();
  Stopwatch watch;
  work();
  context.finish();
  return watch.lap();
}

}  // namespace opaline::gl
