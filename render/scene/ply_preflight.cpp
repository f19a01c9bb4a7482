#include "render/input_error.h"
#include "render/scene/mesh_preflight.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cstring>
#include <map>
#include <sstream>
#include <string_view>
#include <vector>

namespace opaline {
namespace {

struct Property {
  std::string name, type, count_type;  ///< count_type empty: not a list
};
struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};
struct Header {
  std::string format;
  std::vector<Element> elements;
  std::size_t body = 0;   ///< offset of the first byte after the header
  std::size_t lines = 0;  ///< lines of the header
};

/// Bytes of a PLY type; 0 for a name that is none.
std::size_t type_size(const std::string& type) {
  static const std::map<std::string, std::size_t> sizes = {{"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},
                                                           {"short", 2}, {"ushort", 2},  {"int16", 2},  {"uint16", 2},
                                                           {"int", 4},   {"uint", 4},    {"int32", 4},  {"uint32", 4},
                                                           {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto it = sizes.find(type);
  return it == sizes.end() ? 0 : it->second;
}

bool is_signed(const std::string& type) { return type[0] != 'u'; }
bool is_integer(const std::string& type) { return type_size(type) > 0 && type[0] != 'f' && type[0] != 'd'; }

class HeaderReader {
 public:
  HeaderReader(const std::string& bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  Header run() {
    if (next_line() != "ply") fail("a PLY file begins with a line \"ply\"");
    for (std::string line = next_line(); line != "end_header"; line = next_line()) statement(line);
    if (header_.format.empty()) fail("the header has no \"format\" line");
    return header_;
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_, "line " + std::to_string(header_.lines), problem);
  }

  std::string next_line() {
    const std::size_t end = bytes_.find('\n', header_.body);
    if (end == std::string::npos) fail("the file ends early, before \"end_header\"");
    std::string line = bytes_.substr(header_.body, end - header_.body);
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    header_.body = end + 1;
    ++header_.lines;
    return line;
  }

  void statement(const std::string& line) {
    std::istringstream words(line);
    std::string name;
    words >> name;
    if (name == "format") return format(words);
    if (name == "element") return element(words);
    if (name == "property") return property(words);
    if (name != "comment" && name != "obj_info" && !name.empty()) fail("unknown PLY header line \"" + line + "\"");
  }

  void format(std::istringstream& words) {
    words >> header_.format;
    for (const char* valid : {"ascii", "binary_little_endian", "binary_big_endian"}) {
      if (header_.format == valid) return;
    }
    fail("unknown PLY format \"" + header_.format + "\"; valid: ascii, binary_little_endian, binary_big_endian");
  }

  void element(std::istringstream& words) {
    Element e;
    if (!(words >> e.name >> e.count)) fail("\"element\" needs a name and a count");
    header_.elements.push_back(e);
  }

  void property(std::istringstream& words) {
    if (header_.elements.empty()) fail("a property stands before any element");
    Property p;
    words >> p.type;
    if (p.type == "list") words >> p.count_type >> p.type;
    words >> p.name;
    const bool known = type_size(p.type) > 0 && (p.count_type.empty() || is_integer(p.count_type));
    if (!words || !known) fail("a property needs a PLY type and a name");
    header_.elements.back().properties.push_back(p);
  }

  const std::string& bytes_;
  const std::string& path_;
  Header header_;
};

std::string ends_early(const Element& element, std::size_t index) {
  return "the file ends early: in " + element.name + " " + std::to_string(index) + " of " +
         std::to_string(element.count);
}

/// Walks the records of an ascii body, one a line.
class AsciiBody {
 public:
  AsciiBody(const std::string& bytes, const Header& header, const std::string& path)
      : bytes_(bytes), path_(path), cursor_(header.body), line_(header.lines) {}

  void record(const Element& element, std::size_t index) {
    if (!next_line()) throw InputError(path_, "line " + std::to_string(line_), ends_early(element, index));
    for (const Property& p : element.properties) {
      const double count = p.count_type.empty() ? 1 : number(element, index);
      if (count < 0) fail("a list has the length " + std::to_string(count));
      for (double i = 0; i < count; ++i) number(element, index);
    }
    skip_space();
    if (!rest_.empty()) fail("more numbers than a " + element.name + " has");
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw InputError(path_, "line " + std::to_string(line_), problem);
  }

  void skip_space() { rest_.remove_prefix(std::min(rest_.find_first_not_of(" \t\r"), rest_.size())); }

  bool next_line() {
    for (rest_ = {}; rest_.empty(); skip_space()) {
      if (cursor_ >= bytes_.size()) return false;
      const std::size_t end = std::min(bytes_.find('\n', cursor_), bytes_.size());
      rest_ = std::string_view(bytes_).substr(cursor_, end - cursor_);
      cursor_ = end + 1;
      ++line_;
    }
    return true;
  }

  double number(const Element& element, std::size_t index) {
    skip_space();
    if (rest_.empty()) fail(cursor_ >= bytes_.size() ? ends_early(element, index) : "too few numbers");
    const std::string_view word = rest_.substr(0, rest_.find_first_of(" \t\r"));
    const std::string_view digits = word.substr(word[0] == '+' ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (error == std::errc::invalid_argument || end != digits.data() + digits.size()) {
      fail("\"" + std::string(word.substr(0, 40)) + "\" is not a number");
    }
    rest_.remove_prefix(word.size());
    return value;
  }

  const std::string& bytes_;
  const std::string& path_;
  std::size_t cursor_, line_;
  std::string_view rest_;
};

/// Walks the records of a binary body by their sizes.
class BinaryBody {
 public:
  BinaryBody(const std::string& bytes, const Header& header, const std::string& path)
      : bytes_(bytes),
        path_(path),
        cursor_(header.body),
        swap_((header.format == "binary_big_endian") == (std::endian::native == std::endian::little)) {}

  void record(const Element& element, std::size_t index) {
    for (const Property& p : element.properties) {
      const std::size_t count = p.count_type.empty() ? 1 : length(p.count_type, element, index);
      advance(count * type_size(p.type), element, index);
    }
  }

 private:
  std::size_t advance(std::size_t size, const Element& element, std::size_t index) {
    if (size > bytes_.size() - cursor_) throw InputError(path_, "", ends_early(element, index));
    cursor_ += size;
    return cursor_ - size;
  }

  std::size_t length(const std::string& type, const Element& element, std::size_t index) {
    const std::size_t size = type_size(type);
    const std::size_t start = advance(size, element, index);
    std::size_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t byte = static_cast<unsigned char>(bytes_[start + (swap_ ? i : size - 1 - i)]);
      value = value << 8 | byte;
    }
    const bool negative = is_signed(type) && (value >> (8 * size - 1) & 1) != 0;
    if (negative || value > bytes_.size()) throw InputError(path_, "", ends_early(element, index));
    return value;
  }

  const std::string& bytes_;
  const std::string& path_;
  std::size_t cursor_;
  bool swap_;  ///< most significant byte first
};

template <typename Body>
void walk(Body body, const Header& header) {
  for (const Element& element : header.elements) {
    if (element.properties.empty()) continue;
    for (std::size_t i = 0; i < element.count; ++i) body.record(element, i);
  }
}

void require_element(const Header& header, const std::string& name, const std::string& path) {
  const auto same = [&](const Element& e) { return e.name == name && e.count > 0; };
  if (std::none_of(header.elements.begin(), header.elements.end(), same)) {
    throw InputError(path, "", "the mesh is empty: the PLY header names no element \"" + name + "\"");
  }
}

}  // namespace

void check_ply(const std::string& bytes, const std::string& path) {
  const Header header = HeaderReader(bytes, path).run();
  require_element(header, "vertex", path);
  require_element(header, "face", path);
  if (header.format == "ascii") {
    walk(AsciiBody(bytes, header, path), header);
  } else {
    walk(BinaryBody(bytes, header, path), header);
  }
}

}  // namespace opaline
