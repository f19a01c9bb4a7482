// Hashes of content, by which what was made once is found again.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace opaline {

/// FNV-1a, 64 bits. Every `add` also takes in the length, so that "ab" + "c" is not "a" + "bc".
class ContentHash {
 public:
  ContentHash& add(std::string_view bytes);
  /// 16 hexadecimal digits.
  std::string hex() const;

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

/// Hash of the running program's own file: another build may give other numbers.
const std::string& program_hash();

}  // namespace opaline
