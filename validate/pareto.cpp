#include "validate/pareto.h"

#include <algorithm>
#include <cmath>

namespace opaline {

double picture_seconds(const Record& record) {
  return record.seconds.irradiance + record.seconds.prepare.median + record.seconds.render.median;
}

std::vector<CostPoint> cost_points(const std::vector<Record>& records, const std::string& metric) {
  std::vector<CostPoint> points;
  for (std::size_t i = 0; i < records.size(); ++i) {
    const auto error = records[i].error.find(metric);
    if (records[i].status != CellStatus::done || error == records[i].error.end()) continue;
    if (std::isfinite(error->second)) points.push_back({i, picture_seconds(records[i]), std::abs(error->second)});
  }
  return points;
}

std::vector<CostPoint> pareto_front(std::vector<CostPoint> points, double least_gain) {
  std::stable_sort(points.begin(), points.end(), [](const CostPoint& a, const CostPoint& b) {
    return a.seconds != b.seconds ? a.seconds < b.seconds : a.error < b.error;
  });
  std::vector<CostPoint> front;
  for (const CostPoint& point : points)
    if (front.empty() || point.error < (1 - least_gain) * front.back().error) front.push_back(point);
  return front;
}

const CostPoint* cheapest_under(const std::vector<CostPoint>& front, double max_error) {
  const auto it =
      std::find_if(front.begin(), front.end(), [&](const CostPoint& point) { return point.error <= max_error; });
  return it == front.end() ? nullptr : &*it;
}

const CostPoint* most_accurate_under(const std::vector<CostPoint>& front, double max_seconds) {
  const CostPoint* best = nullptr;
  for (const CostPoint& point : front)
    if (point.seconds <= max_seconds) best = &point;
  return best;
}

}  // namespace opaline
