#include "render/choices.h"

#include <algorithm>
#include <cctype>
#include <numeric>

namespace opaline {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Levenshtein distance, one row of the table at a time.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substituted, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string nearest_choice(const std::string& given, const std::vector<std::string>& valid) {
  std::string nearest;
  std::size_t best = 3;
  for (const std::string& name : valid) {
    const std::size_t distance = edit_distance(lower(given), lower(name));
    // A name as short as the distance shares nothing with what was given.
    if (distance < best && distance < std::max(given.size(), name.size())) {
      best = distance;
      nearest = name;
    }
  }
  return nearest;
}

std::string unknown_choice(const std::string& kind, const std::string& given, const std::vector<std::string>& valid) {
  const std::string nearest = nearest_choice(given, valid);
  const std::string question = nearest.empty() ? "" : " did you mean \"" + nearest + "\"?";
  return "unknown " + kind + " \"" + given + "\";" + question + " valid " + kind + "s: " + join_names(valid);
}

std::string join_names(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text.empty() ? "none" : text;
}

}  // namespace opaline
