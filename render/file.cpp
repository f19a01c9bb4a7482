#include "render/file.h"

#include "render/input_error.h"

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>

namespace opaline {
namespace {

namespace fs = std::filesystem;

/// Unique in this process by the counter, among processes by the process number.
fs::path sibling_name(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  const std::string tag = ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(counter++);
  return path.parent_path() / (path.stem().string() + tag + path.extension().string());
}

void check_destination(const fs::path& path) {
  std::error_code ignored;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!path.has_filename() || fs::is_directory(path, ignored)) {
    throw InputError(path.string(), "", "cannot be written: it names a folder, not a file");
  }
  if (!fs::is_directory(folder, ignored)) {
    throw InputError(path.string(), "", "cannot be written: the folder \"" + folder.string() + "\" does not exist");
  }
}

}  // namespace

std::string read_file(const std::string& path) {
  std::error_code ignored;
  if (!fs::exists(path, ignored)) throw InputError(path, "", "the file does not exist");
  if (fs::is_directory(path, ignored)) throw InputError(path, "", "is a folder, not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path, "", "cannot be opened for reading");
  std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (in.bad()) throw InputError(path, "", "cannot be read to its end");
  return bytes;
}

void write_file_atomically(const std::string& path, const std::function<void(const std::string&)>& write) {
  check_destination(path);
  const fs::path temporary = sibling_name(path);
  try {
    write(temporary.string());
    fs::rename(temporary, path);
  } catch (const std::exception& error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw InputError(path, "", std::string("cannot be written: ") + error.what());
  }
}

}  // namespace opaline
