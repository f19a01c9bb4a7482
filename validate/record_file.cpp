// Reading and writing of whole files of records (declared in record.h).
#include "render/file.h"
#include "render/input_error.h"
#include "validate/record.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace opaline {
namespace {

using nlohmann::json;

/// Keeps the last of several records of one name, at its own place in the order.
void keep_last(RecordFile& file) {
  std::map<std::string, std::size_t> last;
  for (std::size_t i = 0; i < file.records.size(); ++i) last[file.records[i].name()] = i;
  std::vector<Record> kept;
  for (std::size_t i = 0; i < file.records.size(); ++i)
    if (last[file.records[i].name()] == i) kept.push_back(std::move(file.records[i]));
  file.superseded = file.records.size() - kept.size();
  file.records = std::move(kept);
}

/// Null for text that is no JSON.
json parsed(std::string_view line) { return json::parse(line, nullptr, false); }

[[noreturn]] void fail(const std::string& path) {
  throw InputError(path, "", std::string("cannot be written: ") + std::strerror(errno));
}

/// Ends the last line of an open file: with what it lacks if it is whole but for that, else by leaving it out.
bool end_last_line(int file, const std::string& path) {
  const std::string text = read_file(path);
  const std::size_t begin = text.rfind('\n') + 1;  // npos + 1 is 0
  if (begin == text.size()) return true;
  if (parsed(std::string_view(text).substr(begin)).is_discarded())
    return ::ftruncate(file, static_cast<::off_t>(begin)) == 0;
  return ::write(file, "\n", 1) == 1;
}

}  // namespace

RecordFile read_records(const std::string& path) {
  const std::string text = read_file(path);
  RecordFile file;
  std::size_t number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line(text.data() + begin, end - begin);
    const std::string place = "line " + std::to_string(++number);
    const bool unended = end == text.size();
    begin = end + 1;
    if (line.empty()) continue;
    const json document = parsed(line);
    if (document.is_discarded() && !unended) throw InputError(path, place, "is not valid JSON");
    if (document.is_discarded())
      file.cut = true;
    else
      file.records.push_back(record_from_json(document, path, place));
  }
  keep_last(file);
  return file;
}

RecordWriter::RecordWriter(const std::string& path)
    : path_(path), file_(::open(path.c_str(), O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0666)) {
  if (file_ < 0 || !end_last_line(file_, path)) fail(path);
}

RecordWriter::~RecordWriter() { ::close(file_); }

void RecordWriter::append(const Record& record) {
  const std::string line =
      to_json(record).dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  for (std::size_t at = 0; at < line.size();) {
    const ::ssize_t written = ::write(file_, line.data() + at, line.size() - at);
    if (written < 0 && errno != EINTR) fail(path_);
    if (written > 0) at += static_cast<std::size_t>(written);
  }
  if (::fsync(file_) != 0 && errno != EINVAL) fail(path_);
}

}  // namespace opaline
