// Error against time: which techniques and settings are worth having, and which to take under a limit.
#pragma once

#include "validate/record.h"

#include <string>
#include <vector>

namespace opaline {

/// Seconds of a scene's first picture: irradiance (where the technique needs it), prepare and one frame.
double picture_seconds(const Record& record);

/// A record's place in the plane of error and time.
struct CostPoint {
  std::size_t record = 0;  ///< index into what it was made of
  double seconds = 0, error = 0;
};

/// The records that are done and have that error (against the reference), with picture_seconds. Errors that are not
/// finite are left out.
std::vector<CostPoint> cost_points(const std::vector<Record>& records, const std::string& metric);

/// The points that no other beats: none is at once as fast and as accurate, and better in one of the two. By ascending
/// seconds, with falling error; of equal points the first. With least_gain > 0 a slower point must have an error below
/// (1 - least_gain) times that of the one before it: what differs less is the same.
std::vector<CostPoint> pareto_front(std::vector<CostPoint> points, double least_gain = 0);

/// The fastest point whose error is at most the limit, or null.
const CostPoint* cheapest_under(const std::vector<CostPoint>& front, double max_error);

/// The most accurate point whose seconds are at most the limit, or null.
const CostPoint* most_accurate_under(const std::vector<CostPoint>& front, double max_seconds);

}  // namespace opaline
