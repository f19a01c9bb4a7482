// The pictures a report embeds: which of the records' images, how small, and where they go.
#pragma once

#include "reports/report_data.h"

#include <string>
#include <vector>

namespace opaline {

/// Most bytes all embedded pictures may take (as data URIs), so that a report stays under 25 MB.
inline constexpr std::size_t gallery_budget = 17'000'000;

/// json: {"images": {KEY: data URI}, "entries": [{"label", "kind", "image": KEY, "error": KEY or null, "note"}],
/// "left": index, "right": index}. Entry 0 is the reference where there is one.
struct GalleryScene {
  std::string title;
  nlohmann::ordered_json json;
};

struct Gallery {
  std::vector<GalleryScene> scenes;   ///< those with an image
  std::vector<std::string> problems;  ///< images that are named and could not be shown, with the reason
  std::string size_note;              ///< how much was shrunk or left out to fit the budget
};

/// Up to 200 records with images: all of them; beyond, of each scene, technique and backend the most accurate. Pictures
/// are shrunk, all alike, until they fit the budget.
Gallery make_gallery(const ReportData& data, std::size_t budget = gallery_budget);

}  // namespace opaline
