// Shader programs from sources embedded in the binary.
//
// A stage is a list of source texts compiled as one, after `#version 430 core`; shared functions are a text of their
// own. Compile errors name the text and its line.
#pragma once

#include "render/gl/context.h"

#include <glm/glm.hpp>

#include <stdexcept>
#include <string>
#include <vector>

namespace opaline::gl {

struct ShaderText {
  std::string name;  ///< for messages: its path in the repository
  std::string text;
};

/// The embedded file of that path, e.g. "render/techniques/brute_force.comp". A bug trips a check: unknown name.
ShaderText shader_file(const std::string& path);

/// What a driver says about a shader, with "name:line:" in place of its numbers.
class ShaderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

enum class StageKind { vertex, fragment, compute };

struct Stage {
  StageKind kind;
  std::vector<ShaderText> texts;
};

class Program {
 public:
  /// Throws ShaderError when the driver rejects a stage or their link.
  Program(const Context& context, const std::vector<Stage>& stages);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  /// Uniforms by name; one that the compiler found to be unused is passed over.
  void set(const char* name, int value) const;
  void set(const char* name, float value) const;
  void set(const char* name, const glm::ivec2& value) const;
  void set(const char* name, const glm::vec2& value) const;
  void set(const char* name, const glm::vec3& value) const;
  void set(const char* name, const glm::vec4& value) const;
  void set(const char* name, const glm::mat4& value) const;

  void use() const;
  /// Runs a compute program on that many groups and makes what it wrote visible to what follows.
  void dispatch(unsigned x, unsigned y = 1, unsigned z = 1) const;

 private:
  int location(const char* name) const;
  const Context& context_;
  unsigned id_ = 0;
};

/// A driver's log with its places ("0:100012(5): error", "0(100012) : error", "ERROR: 0:100012:": line 12 of the second
/// text) as "name:12:".
std::string readable_log(const std::string& log, const std::vector<ShaderText>& texts);

}  // namespace opaline::gl
