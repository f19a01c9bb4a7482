#include "reports/analysis.h"

#include "validate/pareto.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace opaline {
namespace {

/// Ranked records in the plane of error and frame time; `record` is the place in `records`.
std::vector<CostPoint> frame_points(const std::vector<const Record*>& records) {
  std::vector<CostPoint> points;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (is_ranked(*records[i])) points.push_back({i, records[i]->seconds.render.median, *error_of(*records[i])});
  return points;
}

}  // namespace

std::vector<SceneGroup> scene_groups(const std::vector<Record>& records) {
  std::vector<SceneGroup> groups;
  std::map<std::pair<std::string, std::string>, std::size_t> places;
  for (const Record& r : records) {
    const auto [place, is_new] = places.try_emplace({r.scene, r.material}, groups.size());
    if (is_new) groups.push_back({r.scene, r.material, {}});
    groups[place->second].records.push_back(&r);
  }
  return groups;
}

std::vector<std::string> technique_names(const std::vector<Record>& records) {
  std::vector<std::string> names;
  std::set<std::string> seen;
  for (const Record& r : records)
    if (seen.insert(r.technique).second) names.push_back(r.technique);
  return names;
}

std::optional<double> error_of(const Record& record, const std::string& metric) {
  const auto it = record.error.find(metric);
  if (record.status != CellStatus::done || it == record.error.end() || !std::isfinite(it->second)) return {};
  return it->second;
}

std::optional<double> truth_error_of(const Record& record) {
  if (record.status != CellStatus::done || !record.truth_error) return {};
  const auto it = record.truth_error->find(headline_error);
  return it != record.truth_error->end() && std::isfinite(it->second) ? std::optional(it->second) : std::nullopt;
}

bool is_ranked(const Record& record) {
  const double time = record.seconds.render.median;
  return error_of(record).has_value() && std::isfinite(time) && time > 0;
}

std::vector<const Record*> frame_front(const std::vector<const Record*>& records) {
  std::vector<const Record*> front;
  for (const CostPoint& point : pareto_front(frame_points(records))) front.push_back(records[point.record]);
  return front;
}

const Record* cheapest_within(const std::vector<const Record*>& records, double max_error) {
  for (const Record* r : frame_front(records))
    if (*error_of(*r) <= max_error) return r;
  return nullptr;
}

const Record* most_accurate(const std::vector<const Record*>& records) {
  const std::vector<const Record*> front = frame_front(records);
  return front.empty() ? nullptr : front.back();
}

std::string settings_text(const Record& record) {
  std::string text;
  for (const auto& [key, value] : record.settings) text += (text.empty() ? "" : " ") + key + "=" + value;
  return text.empty() ? "defaults" : text;
}

std::string contender(const Record& record) { return record.technique + ", " + record.backend; }

std::string record_anchor(const Record& record) { return "record-" + record.cell; }

}  // namespace opaline
