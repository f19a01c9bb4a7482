// Reading and writing of whole JSON files (declared in json_object.h).
#include "render/file.h"
#include "render/input_error.h"
#include "render/scene/json_object.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <set>

namespace opaline {
namespace {

using nlohmann::json;

std::string line_and_column(const std::string& text, std::size_t offset) {
  const std::size_t end = std::min(offset, text.size());
  const auto begin = text.begin();
  const auto line = 1 + std::count(begin, begin + static_cast<std::ptrdiff_t>(end), '\n');
  const std::size_t newline = end == 0 ? std::string::npos : text.rfind('\n', end - 1);
  const std::size_t column = 1 + (newline == std::string::npos ? end : end - newline - 1);
  return "line " + std::to_string(line) + ":" + std::to_string(column);
}

/// Where the word (letters, sign) around `offset` begins, so that "NaN" is pointed at by its N.
std::size_t word_start(const std::string& text, std::size_t offset) {
  const auto in_word = [&](std::size_t i) { return std::isalpha(static_cast<unsigned char>(text[i])) != 0; };
  std::size_t start = std::min(offset, text.size());
  while (start > 0 && in_word(start - 1)) --start;
  return start > 0 && text[start - 1] == '-' && start < text.size() && in_word(start) ? start - 1 : start;
}

bool is_non_finite_word(const std::string& text, std::size_t start) {
  std::string word;
  for (std::size_t i = start; i < text.size() && word.size() < 4; ++i) {
    if (text[i] != '-') word += static_cast<char>(std::tolower(static_cast<unsigned char>(text[i])));
  }
  return word.substr(0, 3) == "nan" || word.substr(0, 3) == "inf";
}

/// nlohmann's own words without its prefix and its position, which we give in our form.
std::string reason(const std::string& what) {
  const std::size_t start = what.find("syntax error");
  return start == std::string::npos ? what : what.substr(start);
}

[[noreturn]] void throw_malformed(const std::string& path, const std::string& text, const json::parse_error& error) {
  const std::size_t offset = error.byte == 0 ? 0 : error.byte - 1;
  const std::size_t start = word_start(text, offset);
  if (is_non_finite_word(text, start)) {
    throw InputError(path, line_and_column(text, start),
                     "NaN and Infinity are not JSON numbers; write a finite number");
  }
  throw InputError(path, line_and_column(text, offset), "is not valid JSON: " + reason(error.what()));
}

/// Parser callback that rejects a key given twice in one object, which nlohmann would drop quietly.
class DuplicateKeys {
 public:
  explicit DuplicateKeys(std::string path) : path_(std::move(path)) {}

  bool operator()(int, json::parse_event_t event, const json& parsed) {
    if (event == json::parse_event_t::object_start) open_.emplace_back();
    if (event == json::parse_event_t::object_end) open_.pop_back();
    if (event == json::parse_event_t::key && !open_.back().insert(parsed.get<std::string>()).second) {
      throw InputError(path_, "", "the key \"" + parsed.get<std::string>() + "\" stands twice in one object");
    }
    return true;
  }

 private:
  std::string path_;
  std::vector<std::set<std::string>> open_;
};

}  // namespace

json read_json_file(const std::string& path) {
  const std::string text = read_file(path);
  try {
    return json::parse(text, DuplicateKeys(path));
  } catch (const json::parse_error& error) {
    throw_malformed(path, text, error);
  } catch (const json::out_of_range& error) {
    throw InputError(path, "", std::string("holds a number that no double can hold: ") + error.what());
  }
}

void write_text_atomically(const std::string& path, const std::string& text) {
  write_file_atomically(path, [&](const std::string& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw std::runtime_error("the disk is full or the folder is read-only");
  });
}

}  // namespace opaline
