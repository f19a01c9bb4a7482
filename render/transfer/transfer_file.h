// Transfer tables in a file, part by part, so that a long precomputation can be stopped and taken up again.
//
// While parts are missing the file is called NAME.part; when all are there it gets an end mark and its name. Every part
// carries the key of what it was made from (geometry, material, profile, settings, lights' nodes) and a checksum.
//   NAME        whole or refused: another version, another key, a wrong checksum or no end mark is an InputError
//   NAME.part   refused for another version or key; parts that are not whole are made again
//
// Layout, little-endian: "opaline\ntransfer", u64 version; then records of u64 object, part, key, bytes, the rows as
// floats, u64 checksum. The end mark is a record with object = ~0, part = number of records, nothing else.
#pragma once

#include "render/transfer/transfer_table.h"

#include <cstdint>
#include <fstream>
#include <map>
#include <string>

namespace opaline {

/// A 64-bit FNV-1a hash of whatever a table depends on, value by value.
class TransferKey {
 public:
  TransferKey& add(const void* bytes, std::size_t count);
  template <typename T>
  TransferKey& add(const std::vector<T>& values) {
    add_number(static_cast<double>(values.size()));
    return add(values.data(), values.size() * sizeof(T));
  }
  TransferKey& add_number(double value) { return add(&value, sizeof(value)); }
  TransferKey& add_text(const std::string& text) { return add(text.data(), text.size()).add_number(0); }
  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

class TransferFile {
 public:
  static constexpr std::uint64_t version = 1;

  /// Looks at NAME, or else at NAME.part, or begins that. Throws InputError as above, or if it cannot be written.
  explicit TransferFile(std::string name);

  /// How a table's parts are restored and kept; the file must outlive it.
  TransferStore store(std::uint64_t object, std::uint64_t key);
  /// All parts are there: gives the file its name.
  void finish();

  bool complete() const { return complete_; }

 private:
  struct Record {
    std::uint64_t key, bytes;
    std::streamoff at;  ///< of its floats
  };
  void read_records();
  [[noreturn]] void refuse(const std::string& why) const;
  bool restore(std::uint64_t object, std::uint64_t key, std::size_t part, TransferTable& table);
  void keep(std::uint64_t object, std::uint64_t key, std::size_t part, const TransferTable& table);
  void write(const void* bytes, std::size_t count);

  std::string name_, path_;  ///< path_: what is read or written now
  bool complete_ = false;
  std::map<std::pair<std::uint64_t, std::uint64_t>, Record> records_;
  std::fstream file_;
};

}  // namespace opaline
