// Small pictures as text: what a report draws with.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace opaline::svg {

using Points = std::vector<std::pair<double, double>>;

/// A plot with axes; logarithmic axes take positive values only, others are left out.
class Plot {
 public:
  struct Axis {
    std::string label;
    double low = 0, high = 1;
    bool logarithmic = false;
  };
  Plot(Axis x, Axis y);
  void line(const Points& points, const std::string& colour, double width = 1.2);
  /// Between two lines with the same x.
  void band(const Points& low, const Points& high, const std::string& colour);
  /// From the x axis up.
  void bars(const Points& centres, double width, const std::string& colour);
  /// The whole element; `title` is its accessible name.
  std::string text(const std::string& title) const;

 private:
  double place_x(double x) const;
  double place_y(double y) const;
  bool shows(double x, double y) const;
  Axis x_, y_;
  std::string body_;
};

/// A square of coloured cells, -1 blue, 0 white, 1 red, with names beside.
std::string matrix(const std::vector<std::vector<double>>& values, const std::vector<std::string>& names,
                   const std::string& title);

/// <, >, & and quotes as HTML writes them.
std::string escaped(const std::string& text);

}  // namespace opaline::svg
