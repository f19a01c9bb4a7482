#include "fit/report/svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace opaline::svg {
namespace {

constexpr double width = 420, height = 260, left = 58, right = 12, top = 10, bottom = 40;

double share(const Plot::Axis& axis, double v) {
  if (axis.logarithmic) return std::log(v / axis.low) / std::log(axis.high / axis.low);
  return (v - axis.low) / (axis.high - axis.low);
}

/// Four to six round values, or powers of ten.
std::vector<double> ticks(const Plot::Axis& axis) {
  std::vector<double> out;
  if (axis.logarithmic) {
    const int first = static_cast<int>(std::ceil(std::log10(axis.low) - 1e-9)),
              last = static_cast<int>(std::floor(std::log10(axis.high) + 1e-9));
    const int step = std::max(1, (last - first + 4) / 5);
    for (int e = first; e <= last; e += step) out.push_back(std::pow(10.0, e));
    return out;
  }
  const double raw = (axis.high - axis.low) / 5, unit = std::pow(10.0, std::floor(std::log10(raw)));
  const double step = raw / unit < 1.5 ? unit : raw / unit < 3.5 ? 2 * unit : raw / unit < 7.5 ? 5 * unit : 10 * unit;
  for (double v = std::ceil(axis.low / step) * step; v <= axis.high + 1e-9 * step; v += step)
    out.push_back(std::abs(v) < 1e-9 * step ? 0 : v);
  return out;
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

Plot::Plot(Axis x, Axis y) : x_(std::move(x)), y_(std::move(y)) {
  const double floor = height - bottom;
  for (const double v : ticks(x_))
    body_ += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='{1}' y2='{2}' stroke='#ddd'/><text x='{0:.1f}' y='{3}' "
        "text-anchor='middle'>{4:.3g}</text>",
        place_x(v), top, floor, floor + 14, v);
  for (const double v : ticks(y_))
    body_ += fmt::format(
        "<line x1='{0}' x2='{1}' y1='{2:.1f}' y2='{2:.1f}' stroke='#ddd'/><text x='{3}' y='{4:.1f}' "
        "text-anchor='end'>{5:.3g}</text>",
        left, width - right, place_y(v), left - 5, place_y(v) + 3, v);
  body_ += fmt::format(
      "<rect x='{}' y='{}' width='{}' height='{}' fill='none' stroke='#666'/><text x='{}' y='{}' "
      "text-anchor='middle'>{}</text><text transform='translate(12 {}) rotate(-90)' text-anchor='middle'>{}</text>",
      left, top, width - left - right, height - top - bottom, (left + width - right) / 2, height - 8, escaped(x_.label),
      (top + height - bottom) / 2, escaped(y_.label));
}

double Plot::place_x(double x) const { return left + (width - left - right) * std::clamp(share(x_, x), 0.0, 1.0); }
double Plot::place_y(double y) const {
  return height - bottom - (height - top - bottom) * std::clamp(share(y_, y), 0.0, 1.0);
}
bool Plot::shows(double x, double y) const {
  return std::isfinite(x) && std::isfinite(y) && (!x_.logarithmic || x > 0) && (!y_.logarithmic || y > 0);
}

void Plot::line(const Points& points, const std::string& colour, double stroke) {
  body_ += fmt::format("<polyline fill='none' stroke='{}' stroke-width='{}' points='", colour, stroke);
  for (const auto& [x, y] : points)
    if (shows(x, y)) body_ += fmt::format("{:.1f},{:.1f} ", place_x(x), place_y(y));
  body_ += "'/>";
}

void Plot::band(const Points& low, const Points& high, const std::string& colour) {
  body_ += fmt::format("<polygon fill='{}' fill-opacity='0.25' points='", colour);
  for (const auto& [x, y] : low)
    if (shows(x, y)) body_ += fmt::format("{:.1f},{:.1f} ", place_x(x), place_y(y));
  for (auto p = high.rbegin(); p != high.rend(); ++p)
    if (shows(p->first, p->second)) body_ += fmt::format("{:.1f},{:.1f} ", place_x(p->first), place_y(p->second));
  body_ += "'/>";
}

void Plot::bars(const Points& centres, double bar, const std::string& colour) {
  for (const auto& [x, y] : centres)
    body_ += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}' fill-opacity='0.5'/>",
                         place_x(x - bar / 2), place_y(y), place_x(x + bar / 2) - place_x(x - bar / 2),
                         height - bottom - place_y(y), colour);
}

std::string Plot::text(const std::string& title) const {
  return fmt::format(
      "<svg role='img' viewBox='0 0 {} {}' width='{}' font-size='10' "
      "font-family='sans-serif'><title>{}</title>{}</svg>\n",
      width, height, width, escaped(title), body_);
}

std::string matrix(const std::vector<std::vector<double>>& values, const std::vector<std::string>& names,
                   const std::string& title) {
  constexpr double cell = 34, beside = 150;
  const double n = static_cast<double>(values.size()) * cell;
  std::string body;
  for (std::size_t i = 0; i < values.size(); ++i) {
    body += fmt::format("<text x='{}' y='{}' text-anchor='end'>{}</text>", beside - 5,
                        (static_cast<double>(i) + 0.6) * cell, escaped(names[i]));
    for (std::size_t j = 0; j < values.size(); ++j) {
      const double v = std::isfinite(values[i][j]) ? std::clamp(values[i][j], -1.0, 1.0) : 0;
      const int fade = static_cast<int>(std::lround(255 * (1 - std::abs(v))));
      body += fmt::format(
          "<rect x='{}' y='{}' width='{}' height='{}' fill='rgb({},{},{})' stroke='#ccc'/><text x='{}' y='{}' "
          "text-anchor='middle'>{:.2f}</text>",
          beside + static_cast<double>(j) * cell, static_cast<double>(i) * cell, cell, cell, v < 0 ? fade : 255, fade,
          v > 0 ? fade : 255, beside + (static_cast<double>(j) + 0.5) * cell, (static_cast<double>(i) + 0.6) * cell, v);
    }
  }
  return fmt::format(
      "<svg role='img' viewBox='0 0 {0} {1}' width='{0}' font-size='9' "
      "font-family='sans-serif'><title>{2}</title>{3}</svg>\n",
      beside + n, n, escaped(title), body);
}

}  // namespace opaline::svg
