// The interactive plots of error against time. page/plots.js draws them from the data embedded here.
#include "reports/analysis.h"
#include "reports/format.h"
#include "reports/html.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

/// Names of the errors of any record, the headline first. "truth:" before those against path_traced.
std::vector<std::string> metric_names(const std::vector<Record>& records) {
  std::set<std::string> names;
  for (const Record& r : records) {
    for (const auto& [name, ignored] : r.error) names.insert(name);
    if (r.truth_error)
      for (const auto& [name, ignored] : *r.truth_error) names.insert("truth:" + name);
  }
  std::vector<std::string> ordered(names.begin(), names.end());
  std::stable_partition(ordered.begin(), ordered.end(), [](const std::string& n) { return n == headline_error; });
  return ordered;
}

/// Errors in the order of `names`; null where there is none, and where it isn't finite.
Json errors(const Record& r, const std::vector<std::string>& names) {
  Json values = Json::array();
  for (const std::string& name : names) {
    const bool truth = name.rfind("truth:", 0) == 0;
    const auto& map = truth && r.truth_error ? *r.truth_error : r.error;
    const auto it = map.find(truth ? name.substr(6) : name);
    values.push_back(it != map.end() && (r.truth_error || !truth) && std::isfinite(it->second) ? Json(it->second)
                                                                                               : Json());
  }
  return values;
}

Json point(const Record& r, std::size_t group, bool on_front, const std::vector<std::string>& metrics) {
  return {{"id", record_anchor(r)},
          {"group", group},
          {"technique", r.technique},
          {"backend", r.backend},
          {"settings", settings_text(r)},
          {"render", r.seconds.render.median},
          {"prepare", r.seconds.prepare.median},
          {"irradiance", r.seconds.irradiance},
          {"front", on_front},
          {"errors", errors(r, metrics)}};
}

Json plot_data(const ReportData& data) {
  const std::vector<std::string> metrics = metric_names(data.records);
  Json json = {{"metrics", metrics},
               {"techniques", technique_names(data.records)},
               {"groups", Json::array()},
               {"points", Json::array()}};
  const auto groups = scene_groups(data.records);
  for (std::size_t g = 0; g < groups.size(); ++g) {
    json["groups"].push_back(groups[g].title());
    const auto front = frame_front(groups[g].records);
    for (const Record* r : groups[g].records) {
      if (r->status != CellStatus::done) continue;
      json["points"].push_back(point(*r, g, std::find(front.begin(), front.end(), r) != front.end(), metrics));
    }
  }
  return json;
}

/// Controls and an empty plot; the script fills both.
std::string plot_html(const ReportData& data) {
  return fmt::format(R"(<div class="plot-controls" id="plot-controls"></div>
<fieldset class="toggles" id="technique-toggles"><legend>Techniques</legend></fieldset>
<fieldset class="toggles" id="backend-toggles"><legend>Backends</legend></fieldset>
<div id="error-plot" class="plot" tabindex="0" role="application"
 aria-label="Error against time, both on logarithmic axes. Arrow keys go from point to point, Enter leads to the record."></div>
<p id="plot-status" class="status" role="status" aria-live="polite"></p>
<noscript><p>The plot needs JavaScript; the tables below hold the same numbers.</p></noscript>
<script type="application/json" id="plot-data">{}</script>
)",
                     script_json(plot_data(data)));
}

Table front_table(const std::vector<SceneGroup>& groups) {
  Table table{"Pareto fronts: nothing measured is both faster and at least as accurate",
              {"scene, material", "technique", "settings", "frame", "error"},
              {},
              groups.size() > 12};
  for (const SceneGroup& group : groups) {
    const auto front = frame_front(group.records);
    if (front.empty())
      table.rows.push_back({group.title(), reason_cell("nothing was measured that can be ranked"), reason_cell("-"),
                            reason_cell("-"), reason_cell("-")});
    for (const Record* r : front) {
      TableCell technique(contender(*r));
      technique.link = record_anchor(*r);
      table.rows.push_back({group.title(), technique, code_cell(settings_text(*r)),
                            number_cell(seconds_text(r->seconds.render.median)),
                            number_cell(relative_text(*error_of(*r)))});
    }
  }
  return table;
}

Blocks write(const ReportData& data) {
  if (data.records.empty())
    return {Paragraph{"There are no records: `opaline validate --out DIR` makes them.", Tone::muted}};
  return {
      Paragraph{"Each point is one technique with one choice of settings. Lower is more accurate, further left is "
                "faster; the line is the Pareto front of what is shown. Filled marks are the CPU, open ones the GPU. "
                "Errors are against the hierarchical reference, those marked as truth against path_traced."},
      HtmlFigure{plot_html(data), ""}, front_table(scene_groups(data.records))};
}

}  // namespace

Section error_and_time_section() { return {"error-and-time", "Error against time", write}; }

}  // namespace opaline
