#include "reports/gallery.h"

#include "render/input_error.h"
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t most_records = 200;
constexpr int largest_side = 512, smallest_side = 48;

bool has_picture(const Record& r) { return r.status == CellStatus::done && r.images.count("render") > 0; }

/// Of each technique and backend the most accurate record with an image (unranked ones: the first).
std::vector<const Record*> best_of_each(const SceneGroup& group) {
  std::map<std::string, const Record*> best;
  for (const Record* r : group.records) {
    if (!has_picture(*r)) continue;
    const Record*& place = best[contender(*r)];
    if (place == nullptr || error_of(*r).value_or(1e300) < error_of(*place).value_or(1e300)) place = r;
  }
  std::vector<const Record*> chosen;
  for (const auto& [name, record] : best) chosen.push_back(record);
  return chosen;
}

/// Builds one scene's pictures; images that several records name are read once.
class SceneBuilder {
 public:
  SceneBuilder(const ReportData& data, const SceneGroup& group, int side, std::set<std::string>& problems)
      : data_(data), group_(group), side_(side), problems_(problems) {
    json_ = {{"images", Json::object()}, {"entries", Json::array()}};
    find_reference();
  }

  /// Empty where nothing could be shown.
  Json build(const std::vector<const Record*>& records) {
    for (const Record* r : records) add_record(*r);
    if (json_["entries"].empty()) return {};
    json_["left"] = 0;
    json_["right"] = preferred_right(records);
    return json_;
  }

 private:
  std::string path_of(const std::string& name) const {
    return (std::filesystem::path(data_.directory) / name).string();
  }

  /// What `make` returns, or nothing and a problem noted.
  template <typename Make>
  void guarded(const std::string& what, Make make) {
    try {
      make();
    } catch (const std::exception& error) {
      problems_.insert(what + ": " + error.what());
    }
  }

  void find_reference() {
    for (const Record* r : group_.records) {
      const auto it = r->images.find("reference");
      if (it == r->images.end() || !reference_.data.empty()) continue;
      guarded(it->second, [&] {
        reference_ = read_image(path_of(it->second));
        scale_ = rms(reference_) > 0 ? rms(reference_) : 1;
        exposure_ = auto_exposure(reference_);
        add_entry("reference (hierarchical)", "image", it->second, nullptr,
                  "certified to " + relative_text(r->reference.certified_relative_error));
        embed(it->second, [&] { return tonemapped_png(shrunk(reference_, side_), exposure_); });
      });
    }
  }

  template <typename Png>
  void embed(const std::string& key, Png png) {
    if (!json_["images"].contains(key)) json_["images"][key] = data_uri(png());
  }

  void add_entry(const std::string& label, const std::string& kind, const std::string& image, const Json& error,
                 const std::string& note) {
    json_["entries"].push_back({{"label", label}, {"kind", kind}, {"image", image}, {"error", error}, {"note", note}});
  }

  void add_record(const Record& r) {
    const std::string label = contender(r) + ", " + settings_text(r);
    guarded(r.images.at("render"), [&] { add_render(r, label); });
    if (reference_.data.empty()) return;
    for (const char* layer : {"bound", "variance"})
      if (const auto it = r.images.find(layer); it != r.images.end())
        guarded(it->second, [&] { add_layer(it->second, layer, label); });
    if (const auto it = r.images.find("truth"); it != r.images.end())
      guarded(it->second, [&] { add_truth(it->second, r); });
  }

  void add_render(const Record& r, const std::string& label) {
    const std::string file = r.images.at("render"), error = "error of " + file;
    const Image image = read_image(path_of(file));
    const bool comparable = !reference_.data.empty();
    if (comparable)
      embed(error, [&] { return false_colour_png(shrunk_error(relative_error(image, reference_, scale_))); });
    embed(file, [&] { return tonemapped_png(shrunk(image, side_), comparable ? exposure_ : auto_exposure(image)); });
    add_entry(label, "image", file, comparable ? Json(error) : Json(),
              error_of(r) ? "relative RMSE " + relative_text(*error_of(r)) : "no reference");
  }

  /// A bound or a standard error, on the errors' scale.
  void add_layer(const std::string& file, const std::string& layer, const std::string& label) {
    const std::string key = layer + " " + file, kind = layer == "bound" ? "bound" : "standard error";
    if (json_["images"].contains(key)) return;
    const Image image = read_image(path_of(file));
    embed(key, [&] {
      return false_colour_png(shrunk_error(relative_size(image, reference_, scale_, layer == "variance")));
    });
    add_entry(label, kind, key, nullptr, "relative to the reference's RMS");
  }

  void add_truth(const std::string& file, const Record& r) {
    if (json_["images"].contains(file)) return;
    const std::string error = "error of " + file;
    const Image image = read_image(path_of(file));
    embed(error, [&] { return false_colour_png(shrunk_error(relative_error(image, reference_, scale_))); });
    embed(file, [&] { return tonemapped_png(shrunk(image, side_), exposure_); });
    add_entry("truth (path_traced)", "image", file, error,
              "its standard error is " + relative_text(r.reference.truth_standard_error));
  }

  Image shrunk_error(const Image& relative) const { return shrunk(relative, side_); }

  /// The cheapest within 5 %, else the first that isn't the reference.
  std::size_t preferred_right(const std::vector<const Record*>& records) const {
    const Record* best = cheapest_within(records, 0.05);
    const Json& entries = json_.at("entries");
    for (std::size_t i = 0; i < entries.size(); ++i)
      if (best != nullptr && entries[i]["image"] == best->images.at("render")) return i;
    return entries.size() > 1 ? 1 : 0;
  }

  const ReportData& data_;
  const SceneGroup& group_;
  const int side_;
  std::set<std::string>& problems_;
  Image reference_;
  double scale_ = 1, exposure_ = 1;
  Json json_;
};

std::size_t picture_bytes(const Gallery& gallery) {
  std::size_t bytes = 0;
  for (const GalleryScene& scene : gallery.scenes)
    for (const auto& [key, uri] : scene.json["images"].items())
      bytes += uri.get_ref<const std::string&>().size() + key.size();
  return bytes;
}

Gallery gallery_of_side(const ReportData& data, int side, bool all) {
  Gallery gallery;
  std::set<std::string> problems;
  const auto groups = scene_groups(data.records);
  for (const SceneGroup& group : groups) {
    std::vector<const Record*> chosen = best_of_each(group);
    if (all) {
      chosen.clear();
      std::copy_if(group.records.begin(), group.records.end(), std::back_inserter(chosen),
                   [](const Record* r) { return has_picture(*r); });
    }
    Json json = SceneBuilder(data, group, side, problems).build(chosen);
    if (!json.is_null()) gallery.scenes.push_back({group.title(), std::move(json)});
  }
  gallery.problems.assign(problems.begin(), problems.end());
  return gallery;
}

}  // namespace

Gallery make_gallery(const ReportData& data, std::size_t budget) {
  const auto pictured = static_cast<std::size_t>(std::count_if(data.records.begin(), data.records.end(), has_picture));
  const bool all = pictured <= most_records;
  // A PNG of a smooth picture takes 1 to 2 bytes a pixel, 4/3 of that as base64; each record brings an image and its
  // error.
  const double pictures = 2.5 * static_cast<double>(std::min(pictured, most_records)) + 1;
  int side = std::clamp(static_cast<int>(std::sqrt(static_cast<double>(budget) / (pictures * 1.5))), smallest_side,
                        largest_side);
  Gallery gallery = gallery_of_side(data, side, all);
  for (std::size_t bytes = picture_bytes(gallery); bytes > budget && side > 1; bytes = picture_bytes(gallery)) {
    side =
        std::max(1, static_cast<int>(0.9 * side * std::sqrt(static_cast<double>(budget) / static_cast<double>(bytes))));
    gallery = gallery_of_side(data, side, all);
  }
  gallery.size_note = fmt::format(
      "Pictures are at most {} pixels wide and high{}.", side,
      all ? ""
          : fmt::format("; of {} records with images, the most accurate of each scene, technique and backend are shown",
                        pictured));
  return gallery;
}

}  // namespace opaline
