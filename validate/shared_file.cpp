#include "validate/shared_file.h"

#include "render/file.h"
#include "validate/content_hash.h"

#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <type_traits>

namespace opaline {
namespace {

/// Appends values to a string of bytes, or takes them out again: one function describes the layout for both.
class Archive {
 public:
  Archive() = default;
  explicit Archive(std::string bytes) : bytes_(std::move(bytes)), reading_(true) {}

  template <typename T>
  void value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    raw(&v, sizeof v);
  }
  template <typename T>
  void values(std::vector<T>& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::uint64_t size = v.size();
    value(size);
    if (reading_) check(size * sizeof(T)), v.resize(size);
    raw(v.data(), size * sizeof(T));
  }
  template <typename T, typename Each>
  void list(std::vector<T>& v, const Each& each) {
    std::uint64_t size = v.size();
    value(size);
    if (reading_) check(size), v.resize(size);
    for (T& element : v) each(element);
  }
  void counts(std::map<std::string, std::uint64_t>& counts) {
    std::vector<std::pair<std::string, std::uint64_t>> pairs(counts.begin(), counts.end());
    list(pairs, [this](auto& pair) {
      std::vector<char> name(pair.first.begin(), pair.first.end());
      values(name);
      pair.first.assign(name.begin(), name.end());
      value(pair.second);
    });
    counts = {pairs.begin(), pairs.end()};
  }
  const std::string& bytes() const { return bytes_; }

 private:
  void check(std::uint64_t size) const {
    if (size > bytes_.size() - at_) throw std::runtime_error("cut");
  }
  void raw(void* data, std::size_t size) {
    if (size == 0) return;
    if (!reading_) {
      bytes_.append(static_cast<const char*>(data), size);
      return;
    }
    check(size);
    std::memcpy(data, bytes_.data() + at_, size);
    at_ += size;
  }
  std::string bytes_;
  std::size_t at_ = 0;
  bool reading_ = false;
};

void archive(Archive& a, Counters& counters) {
  a.counts(counters.done);
  a.counts(counters.skipped);
}

void archive(Archive& a, SceneParts& parts) {
  a.value(parts.load_seconds);
  a.list(parts.meshes, [&](Mesh& mesh) {
    a.values(mesh.positions);
    a.values(mesh.normals);
    a.values(mesh.uvs);
    a.values(mesh.triangles);
  });
  GBuffer& view = parts.shared.view;
  a.value(view.width);
  a.value(view.height);
  a.value(view.camera);
  a.values(view.points);
  archive(a, view.counters);
  a.list(parts.shared.cells, [&](SurfaceCells& cells) { a.values(cells); });
  a.list(parts.shared.irradiance, [&](IrradianceField& field) {
    a.value(field.etas);
    a.value(field.channels);
    a.value(field.colour);
    a.values(field.values);
    a.values(field.quarters);
  });
  archive(a, parts.shared.counters);
  a.value(parts.shared.seconds);
}

constexpr std::size_t hash_digits = 16;

}  // namespace

void save_scene_parts(const std::string& path, const SceneParts& parts) {
  Archive a;
  SceneParts copy = parts;
  archive(a, copy);
  write_file_atomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out << ContentHash().add(a.bytes()).hex() << a.bytes();
    out.close();
    if (!out) throw std::runtime_error("the disk is full or the folder is read-only");
  });
}

std::optional<SceneParts> load_scene_parts(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return {};
  const std::string file = read_file(path);
  if (file.size() < hash_digits) return {};
  std::string bytes = file.substr(hash_digits);
  if (ContentHash().add(bytes).hex() != file.substr(0, hash_digits)) return {};
  Archive a(std::move(bytes));
  SceneParts parts;
  archive(a, parts);
  return parts;
}

}  // namespace opaline
