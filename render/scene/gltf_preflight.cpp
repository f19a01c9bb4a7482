// Checks of glTF and STL files; see mesh_preflight.h.
#include "render/input_error.h"
#include "render/scene/mesh_preflight.h"

#include <nlohmann/json.hpp>

#include <cstdint>

namespace opaline {
namespace {

using nlohmann::json;

/// Little-endian, as glTF and STL store it.
std::size_t word_at(const std::string& bytes, std::size_t offset) {
  std::size_t value = 0;
  for (std::size_t i = 4; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
  return value;
}

[[noreturn]] void ends_early(const std::string& path, std::size_t size, std::size_t promised) {
  throw InputError(
      path, "", "the file ends early: it has " + std::to_string(size) + " of " + std::to_string(promised) + " bytes");
}

bool is_glb(const std::string& bytes) { return bytes.compare(0, 4, "glTF") == 0; }

/// The JSON chunk of a .glb after its 12 + 8 bytes of headers.
std::string glb_json(const std::string& bytes, const std::string& path) {
  if (bytes.size() < 20) ends_early(path, bytes.size(), 20);
  const std::size_t length = word_at(bytes, 8), chunk = word_at(bytes, 12);
  if (bytes.size() < length) ends_early(path, bytes.size(), length);
  if (chunk > bytes.size() - 20) ends_early(path, bytes.size(), chunk + 20);
  return bytes.substr(20, chunk);
}

std::size_t triangle_count(const json& document, const json& primitive) {
  const int mode = primitive.value("mode", 4);
  if (mode < 4 || mode > 6) return 0;
  const json& attributes = primitive.at("attributes");
  const json& accessor = primitive.contains("indices") ? primitive.at("indices") : attributes.at("POSITION");
  const std::size_t count = document.at("accessors").at(accessor.get<std::size_t>()).at("count").get<std::size_t>();
  if (mode == 4) return count / 3;
  return count < 3 ? 0 : count - 2;
}

std::size_t triangle_count(const json& document) {
  std::size_t total = 0;
  for (const json& mesh : document.value("meshes", json::array())) {
    for (const json& primitive : mesh.at("primitives")) total += triangle_count(document, primitive);
  }
  return total;
}

}  // namespace

std::size_t check_gltf(const std::string& bytes, const std::string& path) {
  const std::string text = is_glb(bytes) ? glb_json(bytes, path) : bytes;
  const json document = json::parse(text, nullptr, false);
  if (document.is_discarded()) throw InputError(path, "", "is not valid glTF: its JSON is malformed or ends early");
  try {
    return triangle_count(document);
  } catch (const json::exception&) {
    return 0;  // not the shape of glTF 2: assimp says what it thinks of it
  }
}

void check_stl(const std::string& bytes, const std::string& path) {
  const std::size_t header = 84, record = 50;
  const bool is_ascii = bytes.compare(0, 5, "solid") == 0 && bytes.find("facet") != std::string::npos;
  if (is_ascii) {
    if (bytes.find("endsolid") == std::string::npos) {
      throw InputError(path, "", "the file ends early: it has no \"endsolid\"");
    }
    return;
  }
  if (bytes.size() < header) ends_early(path, bytes.size(), header);
  const std::size_t promised = header + record * word_at(bytes, 80);
  if (bytes.size() < promised) ends_early(path, bytes.size(), promised);
}

}  // namespace opaline
