#include "validate/advice.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

namespace opaline {
namespace {

using Key = std::tuple<std::string, std::string, std::map<std::string, std::string>>;
using Scenes = std::set<std::pair<std::string, std::string>>;  ///< and their materials

std::size_t count_without(const Scenes& scenes, const Scenes& left_out) {
  return static_cast<std::size_t>(
      std::count_if(scenes.begin(), scenes.end(), [&](const auto& scene) { return left_out.count(scene) == 0; }));
}

double relative_rmse(const Record& r) {
  const auto it = r.error.find("relative_rmse");
  return it == r.error.end() ? HUGE_VAL : it->second;
}

double expected_seconds(const Record& r, double pixels) {
  const double scale = r.film_pixels > 0 ? pixels / static_cast<double>(r.film_pixels) : 1;
  return r.seconds.irradiance + r.seconds.prepare.median + scale * r.seconds.render.median;
}

void take_in(const Record& r, double pixels, Way& way) {
  if (relative_rmse(r) >= way.worst_error) {
    way.worst_error = relative_rmse(r);
    way.worst_scene = r.scene + ", " + r.material;
  }
  way.expected_seconds = std::max(way.expected_seconds, expected_seconds(r, pixels));
  ++way.scenes;
}

}  // namespace

std::vector<Way> ways(const std::vector<Record>& records, double pixels) {
  std::map<Key, Way> by_key;
  std::map<Key, Scenes> excused;
  Scenes scenes;
  for (const Record& r : records) {
    if (r.backend == "external") continue;
    const Key key{r.technique, r.backend, r.settings};
    if (r.status == CellStatus::not_applicable) excused[key].insert({r.scene, r.material});
    if (r.status != CellStatus::done || !std::isfinite(relative_rmse(r))) continue;
    scenes.insert({r.scene, r.material});
    Way& way = by_key[key];
    way.technique = r.technique, way.backend = r.backend, way.settings = r.settings, way.samples = r.samples;
    take_in(r, pixels, way);
  }
  std::vector<Way> all;
  for (auto& [key, way] : by_key)
    if (way.scenes == count_without(scenes, excused[key])) all.push_back(std::move(way));
  return all;
}

std::vector<Way> fastest_within_error(std::vector<Way> all, double max_error) {
  std::erase_if(all, [&](const Way& way) { return !(way.worst_error <= max_error); });
  std::stable_sort(all.begin(), all.end(),
                   [](const Way& a, const Way& b) { return a.expected_seconds < b.expected_seconds; });
  return all;
}

std::vector<Way> most_accurate_within(std::vector<Way> all, double max_seconds) {
  std::erase_if(all, [&](const Way& way) { return !(way.expected_seconds <= max_seconds); });
  std::stable_sort(all.begin(), all.end(), [](const Way& a, const Way& b) { return a.worst_error < b.worst_error; });
  return all;
}

}  // namespace opaline
