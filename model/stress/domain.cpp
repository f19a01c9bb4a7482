#include "model/stress/domain.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace opaline {
namespace {

constexpr double below_one = 1 - 0x1p-53;

/// Near 0, or near 1 with every step of double precision.
double share(SplitMix& random, double low) {
  if (random() & 1) return std::min(below_one, log_uniform(random, low, 1));
  return 1 - log_uniform(random, 0x1p-53, 1);
}

double around_one(SplitMix& random, double low, double high) {
  const std::uint64_t choice = random() % 4;
  if (choice < 2) return log_uniform(random, low, high);
  const double away = log_uniform(random, 1e-15, 0.1);
  return choice == 2 ? 1 + away : 1 - away;
}

double draw(const Axis& axis, SplitMix& random) {
  if (!axis.corners.empty() && random() % 8 == 0) return axis.corners[random() % axis.corners.size()];
  switch (axis.spread) {
    case Spread::logarithmic:
      return log_uniform(random, axis.low, axis.high);
    case Spread::linear:
      return axis.low + (axis.high - axis.low) * uniform(random);
    case Spread::share:
      return share(random, axis.low);
    case Spread::signed_share:
      return std::min(share(random, axis.low), 1 - axis.low) * (random() & 1 ? 1 : -1);
    case Spread::around_one:
      return around_one(random, axis.low, axis.high);
  }
  return axis.low;
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  char brief[32];
  std::snprintf(brief, sizeof brief, "%g", value);
  return std::strtod(brief, nullptr) == value ? brief : text;
}

std::string range(const Axis& axis) {
  switch (axis.spread) {
    case Spread::share:
      return "0 .. 1-2^-53, from " + number(axis.low);
    case Spread::signed_share:
      return number(axis.low - 1) + " .. " + number(1 - axis.low);
    default:
      return number(axis.low) + " .. " + number(axis.high);
  }
}

}  // namespace

double uniform(SplitMix& random) { return static_cast<double>(random() >> 11) * 0x1p-53; }

double log_uniform(SplitMix& random, double low, double high) {
  const double start = std::log(low);
  return std::clamp(std::exp(start + (std::log(high) - start) * uniform(random)), low, high);
}

Input Domain::inputs_at(Input axis_values) const {
  if (to_inputs != nullptr) to_inputs(axis_values);
  return axis_values;
}

std::vector<Input> corner_points(const Domain& domain) {
  std::vector<Input> points = {Input{}};
  for (std::size_t i = 0; i < domain.dimension(); ++i) {
    std::vector<Input> longer;
    for (const Input& point : points) {
      for (const double corner : domain.axes[i].corners) {
        longer.push_back(point);
        longer.back()[i] = corner;
      }
    }
    points = std::move(longer);
  }
  return points;
}

Input random_point(const Domain& domain, SplitMix& random, const Input& before, bool keep) {
  Input point = before;
  const std::size_t last = domain.dimension() - 1;
  for (std::size_t i = keep ? last : 0; i <= last; ++i) point[i] = draw(domain.axes[i], random);
  return point;
}

std::string describe(const Domain& domain) {
  std::string text;
  for (const Axis& axis : domain.axes) {
    text += (text.empty() ? "" : "; ") + axis.name + " " + range(axis);
    if (!axis.corners.empty()) text += " and ";
    for (std::size_t i = 0; i < axis.corners.size(); ++i) text += (i ? ", " : "") + number(axis.corners[i]);
  }
  return text;
}

}  // namespace opaline
