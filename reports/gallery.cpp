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

/// What errors are measured against, and the exposure everything is shown with.
struct Reference {
  Image image;
  double scale = 1, exposure = 1;
};

/// Builds one scene's pictures; an image that several records name is read and embedded once.
class SceneBuilder {
 public:
  SceneBuilder(const ReportData& data, const SceneGroup& group, int side, std::set<std::string>& problems)
      : data_(data), group_(group), side_(side), problems_(problems) {
    json_ = {{"images", Json::object()}, {"entries", Json::array()}};
  }

  /// Null where nothing could be shown.
  Json build(const std::vector<const Record*>& records) {
    for (const Record* r : group_.records) add_reference(*r);
    for (const Record* r : records) add_record(*r);
    if (json_["entries"].empty()) return {};
    json_["left"] = 0;
    json_["right"] = preferred_right(records);
    return json_;
  }

 private:
  Image read(const std::string& name) const {
    return read_image((std::filesystem::path(data_.directory) / name).string());
  }

  /// Runs `make`; what it throws is noted as a problem of that image.
  template <typename Make>
  void guarded(const std::string& what, Make make) {
    try {
      make();
    } catch (const std::exception& error) {
      problems_.insert(what + ": " + error.what());
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

  /// Records with another profile have another reference.
  void add_reference(const Record& r) {
    const auto it = r.images.find("reference");
    if (it == r.images.end() || references_.count(it->second) > 0) return;
    guarded(it->second, [&] {
      Reference made{read(it->second), 1, 1};
      const double level = rms(made.image);
      made.scale = level > 0 ? level : 1;
      made.exposure = auto_exposure(made.image);
      const std::string number = references_.empty() ? "" : fmt::format(", {}", references_.size() + 1);
      add_entry("reference (hierarchical" + number + ")", "image", it->second, nullptr,
                "certified to " + relative_text(r.reference.certified_relative_error));
      embed(it->second, [&] { return tonemapped_png(shrunk(made.image, side_), made.exposure); });
      if (references_.empty()) first_reference_ = it->second;
      references_[it->second] = std::move(made);
    });
  }

  /// The record's own reference, else the scene's first, else null.
  const Reference* reference_of(const Record& r) const {
    const auto own = r.images.find("reference");
    const auto it = references_.find(own != r.images.end() ? own->second : first_reference_);
    return it == references_.end() ? nullptr : &it->second;
  }

  void add_record(const Record& r) {
    const Reference* reference = reference_of(r);
    const std::string& file = r.images.at("render");
    guarded(file, [&] {
      const std::string note = error_of(r) ? "relative RMSE " + relative_text(*error_of(r))
                                           : "no error: " + (r.reason.empty() ? "no reference" : r.reason);
      add_picture(contender(r) + ", " + settings_text(r), file, reference, note);
    });
    if (reference == nullptr) return;
    // By the records' contract the bound is the reference's and the variance the truth's.
    add_layer(r, "bound", "reference (hierarchical)", *reference);
    if (const auto it = r.images.find("truth"); it != r.images.end() && !json_["images"].contains(it->second))
      guarded(it->second, [&] {
        add_picture("truth (path_traced)", it->second, reference,
                    "its standard error is " + relative_text(r.reference.truth_standard_error));
      });
    add_layer(r, "variance", "truth (path_traced)", *reference);
  }

  /// An image and, where there is a reference, its error.
  void add_picture(const std::string& label, const std::string& file, const Reference* reference,
                   const std::string& note) {
    const Image image = read(file);
    const std::string error = "error of " + file;
    if (reference != nullptr)
      embed(error,
            [&] { return false_colour_png(shrunk(relative_error(image, reference->image, reference->scale), side_)); });
    const double exposure = reference != nullptr ? reference->exposure : auto_exposure(image);
    embed(file, [&] { return tonemapped_png(shrunk(image, side_), exposure); });
    add_entry(label, "image", file, reference != nullptr ? Json(error) : Json(), note);
  }

  /// A bound or a standard error, on the errors' scale.
  void add_layer(const Record& r, const std::string& layer, const std::string& label, const Reference& reference) {
    const auto it = r.images.find(layer);
    if (it == r.images.end() || json_["images"].contains(it->second)) return;
    guarded(it->second, [&] {
      const Image image = read(it->second);
      embed(it->second, [&] {
        return false_colour_png(
            shrunk(relative_size(image, reference.image, reference.scale, layer == "variance"), side_));
      });
      add_entry(label, layer == "bound" ? "bound" : "standard error", it->second, nullptr,
                "relative to the reference's RMS");
    });
  }

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
  std::map<std::string, Reference> references_;  ///< by file
  std::string first_reference_;
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
