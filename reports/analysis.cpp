#include "reports/analysis.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace opaline {
namespace {

bool by_time_then_error(const Record* a, const Record* b) {
  const double ta = a->seconds.render.median, tb = b->seconds.render.median;
  return ta != tb ? ta < tb : *error_of(*a) < *error_of(*b);
}

/// Ranked records, fastest first.
std::vector<const Record*> ranked(const std::vector<const Record*>& records) {
  std::vector<const Record*> out;
  std::copy_if(records.begin(), records.end(), std::back_inserter(out), [](const Record* r) { return is_ranked(*r); });
  std::stable_sort(out.begin(), out.end(), by_time_then_error);
  return out;
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

bool is_ranked(const Record& record) {
  const double time = record.seconds.render.median;
  return error_of(record).has_value() && std::isfinite(time) && time > 0;
}

std::vector<const Record*> pareto_front(const std::vector<const Record*>& records) {
  std::vector<const Record*> front;
  for (const Record* r : ranked(records))
    if (front.empty() || *error_of(*r) < *error_of(*front.back())) front.push_back(r);
  return front;
}

const Record* cheapest_within(const std::vector<const Record*>& records, double max_error) {
  for (const Record* r : pareto_front(records))
    if (*error_of(*r) <= max_error) return r;
  return nullptr;
}

const Record* most_accurate(const std::vector<const Record*>& records) {
  const std::vector<const Record*> front = pareto_front(records);
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
