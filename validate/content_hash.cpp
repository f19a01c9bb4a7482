#include "validate/content_hash.h"

#include "render/file.h"

#include <fmt/format.h>

namespace opaline {

ContentHash& ContentHash::add(std::string_view bytes) {
  const auto mix = [this](std::uint64_t byte) { state_ = (state_ ^ byte) * 0x100000001b3u; };
  for (std::uint64_t size = bytes.size(), k = 0; k < 8; ++k) mix((size >> (8 * k)) & 0xff);
  for (const char c : bytes) mix(static_cast<unsigned char>(c));
  return *this;
}

std::string ContentHash::hex() const { return fmt::format("{:016x}", state_); }

const std::string& program_hash() {
  static const std::string hash = ContentHash().add(read_file("/proc/self/exe")).hex();
  return hash;
}

}  // namespace opaline
