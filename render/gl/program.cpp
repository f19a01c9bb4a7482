#include "render/gl/program.h"

#include "model/check.h"

#include <glad/gl.h>

#include <map>
#include <regex>

namespace opaline::gl {
namespace {

const std::map<std::string, std::string>& embedded() {
  static const std::map<std::string, std::string> files = {
#include "shaders.inc"
  };
  return files;
}

GLenum gl_kind(StageKind kind) {
  switch (kind) {
    case StageKind::vertex:
      return GL_VERTEX_SHADER;
    case StageKind::fragment:
      return GL_FRAGMENT_SHADER;
    default:
      return GL_COMPUTE_SHADER;
  }
}

/// Text i starts at line i * lines_per_text + 1: some drivers forget the source number of #line, none the line.
constexpr std::size_t lines_per_text = 100000;

std::string joined(const std::vector<ShaderText>& texts) {
  std::string source = "#version 430 core\n";
  for (std::size_t i = 0; i < texts.size(); ++i)
    source += "#line " + std::to_string(i * lines_per_text + 1) + "\n" + texts[i].text + "\n";
  return source;
}

template <typename GetParameter, typename GetLog>
std::string info_log(GLuint id, GetParameter parameter, GetLog get) {
  GLint length = 0;
  parameter(id, GL_INFO_LOG_LENGTH, &length);
  std::string log(static_cast<std::size_t>(std::max(length, 1)), '\0');
  GLsizei written = 0;
  get(id, static_cast<GLsizei>(log.size()), &written, log.data());
  log.resize(static_cast<std::size_t>(written));
  return log;
}

GLuint compile(const GladGLContext& gl, const Stage& stage) {
  const GLuint shader = gl.CreateShader(gl_kind(stage.kind));
  const std::string source = joined(stage.texts);
  const char* text = source.c_str();
  gl.ShaderSource(shader, 1, &text, nullptr);
  gl.CompileShader(shader);
  GLint compiled = 0;
  gl.GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  const std::string log = info_log(shader, gl.GetShaderiv, gl.GetShaderInfoLog);
  gl.DeleteShader(shader);
  throw ShaderError(readable_log(log, stage.texts));
}

}  // namespace

std::string readable_log(const std::string& log, const std::vector<ShaderText>& texts) {
  static const std::regex place(R"((?:ERROR: |WARNING: )?\b0(?::(\d+)(?:\(\d+\))?|\((\d+)\)) ?:)");
  std::string out;
  auto rest = log.cbegin();
  for (std::sregex_iterator it(log.begin(), log.end(), place), end; it != end; ++it) {
    const std::size_t number = std::stoul(((*it)[1].matched ? (*it)[1] : (*it)[2]).str());
    const std::size_t text = number / lines_per_text, line = number % lines_per_text;
    out.append(rest, (*it)[0].first);
    out += (text < texts.size() ? texts[text].name : "?") + ":" + std::to_string(line) + ":";
    rest = (*it)[0].second;
  }
  return out.append(rest, log.cend());
}

ShaderText shader_file(const std::string& path) {
  const auto it = embedded().find(path);
  OPALINE_CHECK(it != embedded().end());
  return {path, it->second};
}

Program::Program(const Context& context, const std::vector<Stage>& stages) : context_(context) {
  const GladGLContext& gl = context.use();
  std::vector<GLuint> shaders;
  const auto drop_shaders = [&] {
    for (const GLuint shader : shaders) gl.DeleteShader(shader);
  };
  try {
    for (const Stage& stage : stages) shaders.push_back(compile(gl, stage));
  } catch (...) {
    drop_shaders();
    throw;
  }
  id_ = gl.CreateProgram();
  for (const GLuint shader : shaders) gl.AttachShader(id_, shader);
  gl.LinkProgram(id_);
  drop_shaders();
  GLint linked = 0;
  gl.GetProgramiv(id_, GL_LINK_STATUS, &linked);
  if (linked) return;
  const std::string log = info_log(id_, gl.GetProgramiv, gl.GetProgramInfoLog);
  gl.DeleteProgram(id_);
  throw ShaderError("linking " + stages.front().texts.back().name + ": " + log);
}

Program::~Program() { context_.use().DeleteProgram(id_); }

int Program::location(const char* name) const {
  const GladGLContext& gl = context_.use();
  gl.UseProgram(id_);
  return gl.GetUniformLocation(id_, name);
}

void Program::set(const char* name, int v) const { context_.use().Uniform1i(location(name), v); }
void Program::set(const char* name, float v) const { context_.use().Uniform1f(location(name), v); }
void Program::set(const char* name, const glm::ivec2& v) const { context_.use().Uniform2i(location(name), v.x, v.y); }
void Program::set(const char* name, const glm::vec2& v) const { context_.use().Uniform2f(location(name), v.x, v.y); }
void Program::set(const char* name, const glm::vec3& v) const {
  context_.use().Uniform3f(location(name), v.x, v.y, v.z);
}
void Program::set(const char* name, const glm::vec4& v) const {
  context_.use().Uniform4f(location(name), v.x, v.y, v.z, v.w);
}
void Program::set(const char* name, const glm::mat4& v) const {
  context_.use().UniformMatrix4fv(location(name), 1, GL_FALSE, &v[0][0]);
}

void Program::use() const { context_.use().UseProgram(id_); }

void Program::dispatch(unsigned x, unsigned y, unsigned z) const {
  use();
  const GladGLContext& gl = context_.use();
  gl.DispatchCompute(x, y, z);
  gl.MemoryBarrier(GL_ALL_BARRIER_BITS);
}

}  // namespace opaline::gl
