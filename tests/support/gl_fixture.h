// A GL context for a test, or none: tests of the GPU are skipped on a machine without GL.
#pragma once

#include "render/gl/context.h"
#include "render/input_error.h"

#include <iostream>

namespace opaline::test {

inline const char* no_gl = "no OpenGL 4.3 here";

inline std::unique_ptr<gl::Context> context_or_null(gl::Api api = gl::Api::any) {
  try {
    return gl::Context::create(api);
  } catch (const MachineError& error) {
    std::cerr << error.what() << "\n";
    return nullptr;
  }
}

}  // namespace opaline::test
