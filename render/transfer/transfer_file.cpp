#include "render/transfer/transfer_file.h"

#include "render/input_error.h"

#include <fmt/format.h>

#include <cstring>
#include <filesystem>

namespace opaline {
namespace {

namespace fs = std::filesystem;

constexpr char magic[] = "opaline\ntransfer";  // 16 bytes and a zero that is not written
constexpr std::size_t magic_bytes = 16;
constexpr std::uint64_t end_mark = ~0ull;

std::uint64_t checksum(const std::vector<float>& values) {
  std::uint64_t sum = 0xcbf29ce484222325ull;
  for (const float v : values) {
    std::uint32_t bits;
    std::memcpy(&bits, &v, sizeof(bits));
    sum = (sum ^ bits) * 0x100000001b3ull;
    sum ^= sum >> 29;
  }
  return sum;
}

/// The rows of a part, without their padding.
std::vector<float> part_values(const TransferTable& table, std::size_t part) {
  const auto [first, last] = rows_of_part(table, part);
  std::vector<float> values;
  values.reserve((last - first) * table.vertices);
  for (std::size_t r = first; r < last; ++r) values.insert(values.end(), table.row(r), table.row(r) + table.vertices);
  return values;
}

template <typename T>
bool read(std::istream& in, T* values, std::size_t count) {
  return static_cast<bool>(in.read(reinterpret_cast<char*>(values), static_cast<std::streamsize>(count * sizeof(T))));
}

}  // namespace

TransferKey& TransferKey::add(const void* bytes, std::size_t count) {
  const auto* b = static_cast<const unsigned char*>(bytes);
  for (std::size_t i = 0; i < count; ++i) hash_ = (hash_ ^ b[i]) * 0x100000001b3ull;
  return *this;
}

TransferFile::TransferFile(std::string name) : name_(std::move(name)), path_(name_) {
  std::error_code ignored;
  complete_ = fs::exists(name_, ignored);
  if (!complete_) path_ = name_ + ".part";
  const bool begun = complete_ || fs::exists(path_, ignored);
  file_.open(path_, complete_ ? std::ios::in | std::ios::binary
                    : begun   ? std::ios::in | std::ios::out | std::ios::binary
                              : std::ios::in | std::ios::out | std::ios::trunc | std::ios::binary);
  if (!file_) throw InputError(path_, "", begun ? "cannot be opened" : "cannot be written");
  if (begun) {
    read_records();
  } else {
    write(magic, magic_bytes);
    write(&version, sizeof(version));
  }
}

void TransferFile::refuse(const std::string& why) const {
  throw InputError(path_, "", why + "; remove it, or name another file");
}

void TransferFile::read_records() {
  char start[magic_bytes];
  std::uint64_t found = 0;
  if (!read(file_, start, magic_bytes) || std::memcmp(start, magic, magic_bytes) != 0 || !read(file_, &found, 1))
    refuse("is not a file of transfer tables");
  if (found != version) refuse(fmt::format("is of version {}, not {}", found, version));
  std::error_code ignored;
  const auto size = static_cast<std::streamoff>(fs::file_size(path_, ignored));
  std::streamoff whole = file_.tellg();
  bool ended = false;
  for (std::uint64_t head[4]; !ended && read(file_, head, 4);) {
    const std::streamoff at = file_.tellg();
    ended = head[0] == end_mark && head[1] == records_.size();
    if (ended || head[0] == end_mark || head[3] > static_cast<std::uint64_t>(size - at)) break;
    file_.seekg(static_cast<std::streamoff>(head[3]) + static_cast<std::streamoff>(sizeof(std::uint64_t)),
                std::ios::cur);
    if (file_.tellg() > size) break;
    records_[{head[0], head[1]}] = {head[2], head[3], at};
    whole = file_.tellg();
  }
  file_.clear();
  if (complete_ && !ended) refuse("is cut short");
  if (complete_) return;
  fs::resize_file(path_, static_cast<std::uintmax_t>(whole));
}

void TransferFile::write(const void* bytes, std::size_t count) {
  if (!file_.write(static_cast<const char*>(bytes), static_cast<std::streamsize>(count)))
    throw InputError(path_, "", "cannot be written: is there space left?");
}

bool TransferFile::restore(std::uint64_t object, std::uint64_t key, std::size_t part, TransferTable& table) {
  const auto found = records_.find({object, part});
  if (found == records_.end() && !complete_) return false;
  const auto [first, last] = rows_of_part(table, part);
  if (found == records_.end() || found->second.key != key ||
      found->second.bytes != (last - first) * table.vertices * sizeof(float))
    refuse("was made for another shape, material, light or setting");
  std::vector<float> values((last - first) * table.vertices);
  std::uint64_t sum = 0;
  file_.seekg(found->second.at);
  const bool whole = read(file_, values.data(), values.size()) && read(file_, &sum, 1) && sum == checksum(values);
  file_.clear();
  if (!whole && complete_) refuse("is damaged: a checksum is wrong");
  if (!whole) return false;
  for (std::size_t r = first; r < last; ++r)
    std::copy_n(&values[(r - first) * table.vertices], table.vertices, table.row(r));
  return true;
}

void TransferFile::keep(std::uint64_t object, std::uint64_t key, std::size_t part, const TransferTable& table) {
  const std::vector<float> values = part_values(table, part);
  const std::uint64_t head[4] = {object, part, key, values.size() * sizeof(float)}, sum = checksum(values);
  file_.seekp(0, std::ios::end);
  write(head, sizeof(head));
  records_[{object, part}] = {key, head[3], file_.tellp()};
  write(values.data(), head[3]);
  write(&sum, sizeof(sum));
  file_.flush();
}

TransferStore TransferFile::store(std::uint64_t object, std::uint64_t key) {
  return {[this, object, key](std::size_t part, TransferTable& table) { return restore(object, key, part, table); },
          [this, object, key](std::size_t part, const TransferTable& table) { keep(object, key, part, table); }};
}

void TransferFile::finish() {
  if (complete_) return;
  const std::uint64_t head[4] = {end_mark, records_.size(), 0, 0};
  file_.seekp(0, std::ios::end);
  write(head, sizeof(head));
  file_.close();
  std::error_code error;
  fs::rename(path_, name_, error);
  if (error) throw InputError(name_, "", "cannot be written: " + error.message());
  complete_ = true;
}

}  // namespace opaline
