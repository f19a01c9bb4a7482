#include "render/input_error.h"
#include "render/scene/mesh_preflight.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

namespace opaline {
namespace {

using Words = std::vector<std::string_view>;

constexpr std::string_view ignored_statements[] = {
    "g",      "o",   "s",    "mg",    "usemtl",   "mtllib",   "usemap", "maplib",     "l",         "p",     "vp",
    "cstype", "deg", "bmat", "step",  "curv",     "curv2",    "surf",   "parm",       "trim",      "hole",  "scrv",
    "sp",     "end", "con",  "bevel", "c_interp", "d_interp", "lod",    "shadow_obj", "trace_obj", "ctech", "stech"};

/// A word fit for a message: short, and without the control characters of a binary file.
std::string shown(std::string_view word) {
  std::string text(word.substr(0, 40));
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
  return "\"" + text + "\"";
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

class ObjCleaner {
 public:
  ObjCleaner(const std::string& text, const std::string& path) : text_(text), path_(path) {}

  std::string run() {
    clean_.reserve(text_.size());
    while (next_statement()) {
      if (!words_.empty()) statement();
    }
    for (int kind = 0; kind < 3; ++kind) check_highest(kind);
    return std::move(clean_);
  }

 private:
  enum Kind { position, uv, normal };

  [[noreturn]] void fail(const std::string& problem, std::size_t line) const {
    throw InputError(path_, "line " + std::to_string(line), problem);
  }
  [[noreturn]] void fail(const std::string& problem) const { fail(problem, line_); }

  /// Splits the next line, joined with those a backslash continues; false at the end.
  bool next_statement() {
    words_.clear();
    if (cursor_ >= text_.size()) return false;
    line_ = ++last_line_;
    while (split_line() && cursor_ < text_.size()) ++last_line_;
    return true;
  }

  /// Appends the words of one line; true when it ends in a backslash.
  bool split_line() {
    const std::size_t end = std::min(text_.find('\n', cursor_), text_.size());
    std::string_view line(text_.data() + cursor_, end - cursor_);
    cursor_ = end + 1;
    line = line.substr(0, line.find('#'));
    while (!line.empty() && is_space(line.back())) line.remove_suffix(1);
    const bool continued = !line.empty() && line.back() == '\\';
    if (continued) line.remove_suffix(1);
    for (std::size_t i = 0; i < line.size();) {
      const std::size_t start = i;
      while (i < line.size() && !is_space(line[i])) ++i;
      if (i > start) words_.push_back(line.substr(start, i - start));
      while (i < line.size() && is_space(line[i])) ++i;
    }
    return continued;
  }

  void statement() {
    const std::string_view name = words_[0];
    if (name == "v") return vertex(position, 3, words_.size() == 5 ? 4 : 3);
    if (name == "vt") return vertex(uv, 1, 2);
    if (name == "vn") return vertex(normal, 3, 3);
    if (name == "f") return face();
    const auto end = std::end(ignored_statements);
    if (std::find(std::begin(ignored_statements), end, name) != end) return;
    fail("unknown OBJ statement " + shown(name) + "; meshes are read from v, vt, vn and f");
  }

  /// Checks and copies `most` numbers; what follows (a third uv, a vertex colour) isn't used.
  void vertex(Kind kind, std::size_t least, std::size_t most) {
    if (words_.size() < least + 1) {
      fail("\"" + std::string(words_[0]) + "\" needs " + std::to_string(least) + " numbers, but has " +
           std::to_string(words_.size() - 1));
    }
    clean_ += words_[0];
    for (std::size_t i = 1; i <= most; ++i) append_number(i < words_.size() ? words_[i] : "0");
    clean_ += '\n';
    ++count_[kind];
  }

  void append_number(std::string_view word) {
    std::string_view digits = word;
    if (!digits.empty() && digits[0] == '+') digits.remove_prefix(1);
    double value = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (end != digits.data() + digits.size() || error == std::errc::invalid_argument)
      fail(shown(word) + " is not a number");
    const bool fits = error == std::errc() && std::abs(value) <= std::numeric_limits<float>::max();
    if (!fits) fail(shown(word) + " is not a finite 32-bit number");
    const bool negative = digits[0] == '-';
    if (negative) digits.remove_prefix(1);
    clean_ += negative ? " -" : " ";
    if (digits[0] == '.') clean_ += '0';
    clean_ += digits;
  }

  void face() {
    if (words_.size() < 4) fail("a face needs at least 3 vertices, but has " + std::to_string(words_.size() - 1));
    clean_ += 'f';
    for (std::size_t i = 1; i < words_.size(); ++i) corner(words_[i]);
    clean_ += '\n';
  }

  /// "7", "7/1", "7//3" or "7/1/3"; negative numbers count back from the latest.
  void corner(std::string_view word) {
    const std::string_view whole = word;
    for (int kind = 0; kind < 3; ++kind) {
      const std::size_t slash = word.find('/');
      const std::string_view part = word.substr(0, slash);
      if (!part.empty()) reference(kind, part);
      if (part.empty() && kind != uv) fail(shown(whole) + " is not a face vertex");
      if (slash == std::string_view::npos) break;
      if (kind == normal) fail(shown(whole) + " is not a face vertex");
      word.remove_prefix(slash + 1);
    }
    clean_ += ' ';
    clean_ += whole;
  }

  void reference(int kind, std::string_view part) {
    long long index = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), index);
    if (error != std::errc() || end != part.data() + part.size() || index == 0) {
      fail(shown(part) + " is not a vertex number; they count from 1");
    }
    if (index < 0 && -index > count_[kind]) fail(missing(kind, index, count_[kind]));
    if (index > highest_[kind].index) highest_[kind] = {index, line_};
  }

  /// A face may stand before its vertices, so the upper bound is known only at the end.
  void check_highest(int kind) const {
    if (highest_[kind].index > count_[kind]) {
      fail(missing(kind, highest_[kind].index, count_[kind]), highest_[kind].line);
    }
  }

  static std::string missing(int kind, long long index, long long count) {
    const char* names[] = {"vertex", "texture vertex", "normal"};
    return std::string("the face names ") + names[kind] + " " + std::to_string(index) + ", but there are " +
           std::to_string(count) + "; the file may end early";
  }

  struct Highest {
    long long index = 0;
    std::size_t line = 0;
  };
  const std::string& text_;
  const std::string& path_;
  std::string clean_;
  Words words_;
  std::size_t cursor_ = 0, line_ = 0, last_line_ = 0;
  std::array<long long, 3> count_{};
  std::array<Highest, 3> highest_{};
};

}  // namespace

std::string clean_obj(const std::string& text, const std::string& path) { return ObjCleaner(text, path).run(); }

}  // namespace opaline
